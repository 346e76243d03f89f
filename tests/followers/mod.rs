//! A ring of robots that read each other, for tests and measurements.

use std::fmt::Write as _;

/// Robots in a ring, each with a world, an odometer that loops, and a controller that reads its own place and its neighbour's;
/// several of them start at the same place.
pub fn followers(count: usize) -> String {
    let mut text = String::from("observer At(i, r)\n");
    let mut all = Vec::new();
    for number in 0..count {
        let next = (number + 1) % count;
        let _ = writeln!(
            text,
            "proc World{number}_r = (Delay_1 # Odo{number}_r # At_{{{number},r}}) ; In_v{number}<u> ; World{number}_{{r+u}}\n\
             proc Odo{number}_r = Out_{{p{number},r}} ; Odo{number}_r\n\
             proc Follow{number} = (In_p{number}<a> | In_p{next}<b>) ; Out_{{v{number},(b-a)/3}} ; Follow{number}"
        );
        all.push(format!("World{number}_{{{}}} | Follow{number}", number * number % 7));
    }
    format!("{text}system Sys = {}\n", all.join(" | "))
}
