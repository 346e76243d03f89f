//! What is told of sequences without closed form: fixed points, how they move, and their terms; and of phases that come
//! back several ways.

mod common;

fn told(asked: &str) -> String {
    String::from_utf8_lossy(&common::ran(asked).stdout).into_owned()
}

fn solved(map: &str, first: &str) -> String {
    told(&format!("solve r(n+1) = {map}, r(0) = {first}\n"))
}

/// `4/9`, `sqrt(2)`, `3`.
fn number(text: &str) -> f64 {
    let whole = |text: &str| text.parse::<f64>().expect("a number");
    if let Some(digits) = text.strip_prefix('≈') {
        return whole(digits.trim_end_matches('…'));
    }
    match (text.strip_prefix("sqrt("), text.split_once('/')) {
        (Some(inner), _) => whole(inner.trim_end_matches(')')).sqrt(),
        (_, Some((above, below))) => whole(above) / whole(below),
        _ => whole(text),
    }
}

#[test]
fn fixed_points_are_told_of_maps_with_roots_and_in_pieces() {
    for (map, first, line) in [
        ("sqrt(r(n)+2)", "1", "fixed point 2"),
        ("sqrt(r(n)+1)", "0", "fixed point 1/2*sqrt(5)+1/2"),
        ("sqrt(r(n))", "16", "fixed points 0 and 1"),
        ("r(n)+1/r(n)", "1", "it has no fixed point"),
        ("(r(n)+2/r(n))/2", "1", "fixed points -sqrt(2) and sqrt(2)"),
        ("r(n)+(4-r(n))*abs(4-r(n))/10", "0", "fixed point 4"),
        ("max(sqrt(r(n)),r(n)/2)", "10", "fixed points 0 and 1"),
        ("sqrt(r(n)^2+1)", "0", "it has no fixed point"),
        // Of higher degree they are told by their digits, and none is where no real number is.
        ("r(n)^3/4+r(n)/4+1/8", "0", "fixed points ≈-1.810037… and ≈0.168254… and ≈1.641783…, roots of higher degree"),
        ("r(n)+(r(n)-1)*(r(n)^3-2)/100", "1/2", "fixed points 1, and ≈1.259921…, a root of higher degree"),
        // Of a condition the branch that does not count need not have a value.
        ("if r(n) > 2 then sqrt(r(n)-2)+1 else r(n)/2+1/4", "0", "fixed point 1/2"),
        ("r(n)+(r(n)-1)*(r(n)^4+2)/100", "2", "fixed point 1"),
    ] {
        let text = solved(map, first);
        assert!(text.lines().any(|told| told.trim() == line), "{map}: {line}\n{text}");
    }
}

/// With the conditions that they need, and of several sequences or of higher order.
#[test]
fn fixed_points_with_symbols_and_of_several_sequences_are_told() {
    for (asked, line) in [
        (
            "param c\nsolve x(n+1) = x(n)^2+c, x(0) = 0\n",
            "fixed points 1/2-1/2*sqrt(1-4*c) and 1/2*sqrt(1-4*c)+1/2 if 4*c <= 1",
        ),
        ("param r\nsolve x(n+1) = r*x(n)*(1-x(n)), x(0) = 1/2\n", "fixed points 0, and 1-1/r if r != 0"),
        ("param a > 0\nsolve x(n+1) = (x(n)+a/x(n))/2, x(0) = 1\n", "fixed points sqrt(a) and -sqrt(a)"),
        ("param c > 1\nsolve x(n+1) = x(n)^2+c, x(0) = 0\n", "it has no fixed point"),
        (
            "param a\nsolve x(n+1) = x(n)*y(n), y(n+1) = x(n)+a*y(n)-1, x(0) = 2, y(0) = 1/2\n",
            "fixed points (x,y) = (0,1/(a-1)) if a != 1, and (2-a,1)",
        ),
        ("solve x(n+1) = x(n)*y(n), y(n+1) = x(n)+y(n)-1, x(0) = 2, y(0) = 1/2\n", "fixed point (x,y) = (1,1)"),
        ("solve x(n+2) = x(n+1)*x(n)/2+1/4, x(0) = 1/2, x(1) = 1/3\n", "fixed points 1-1/2*sqrt(2) and 1/2*sqrt(2)+1"),
    ] {
        let text = told(asked);
        assert!(text.lines().any(|told| told.trim() == line), "{line}\n{text}");
    }
    // For a = 0 every point is one.
    for map in ["x(n)+a*x(n)^2+a", "x(n)+a*x(n)*(x(n)^2+1)"] {
        assert!(!told(&format!("param a\nsolve x(n+1) = {map}, x(0) = 1\n")).contains("fixed point"), "{map}");
    }
    // One that depends on the index has none that is told.
    assert!(!told("solve x(n+1) = x(n)^2+n, x(0) = 0\n").contains("fixed point"));
}

/// As many terms as of any other map, by their digits, also with powers of the index and with whole parts.
#[test]
fn twenty_terms_are_told() {
    let told_of = |asked: &str, name: &str| {
        let text = told(asked);
        let line =
            text.lines().find_map(|line| line.trim().strip_prefix(&format!("{name} from 0 on: ")).map(str::to_string));
        line.expect("terms")
    };
    for (asked, last) in [
        ("solve x(n+1) = (1/2)^n*x(n)^2+1, x(0) = 0\n", "≈1.000003815"),
        ("solve x(n+1) = floor(x(n)^2/10), x(0) = 37\n", "≈8.840856380e297132"),
    ] {
        let line = told_of(asked, "x");
        let terms: Vec<&str> = line.split(", ").filter(|term| *term != "…").collect();
        assert_eq!((terms.len(), terms.last()), (20, Some(&last)), "{line}");
    }
    let symbolic = told_of("param c\nsolve x(n+1) = x(n)^2+c, x(0) = 0\n", "x");
    assert!(symbolic.ends_with(", …: with its symbols the next term is too long to be of use"), "{symbolic}");
}

/// That something is so for no index is said with a clause that shows it.
#[test]
fn why_it_is_so_for_no_index_is_told() {
    for (asked, why) in [
        (
            "param v > 0, w > v, d > 0\nsolve x(n+1) = x(n)+v, y(n+1) = y(n)+w, x(0) = 0, y(0) = d find n with x(n) >= y(n)\n",
            "it is -d at n = 0 and does not grow from there on",
        ),
        (
            "param p > 0\nsolve x(n+1) = 2*x(n), x(0) = p find n with x(n) < 0\n",
            "it is p at n = 0 and does not fall from there on",
        ),
        (
            "param p > 0\nsolve x(n+1) = x(n)/2+1, x(0) = p find n with x(n) <= 0\n",
            "it goes from p at n = 0 to 2 and stays between them",
        ),
        (
            "solve x(n+1) = x(n)/2, y(n+1) = -y(n), x(0) = 5, y(0) = 4 find n with x(n)+y(n) > 20\n",
            "4*(-1)^n+5*(1/2)^n-20 > 0 for no n: it is at most -11",
        ),
        ("solve x(n+1) = x(n)/2, x(0) = 5 find n with -2*x(n) > 20\n", "it closes in on 0 and never meets the goal"),
    ] {
        let text = told(asked);
        assert!(text.contains("never ") && text.contains(why), "{why}\n{text}");
    }
}

/// Where a piece steps over a value that the next one has, both are one index.
#[test]
fn what_is_clamped_comes_to_its_bound() {
    let text = told("param v > 0, p\nsolve x(n+1) = clamp(x(n)+v,0,10), x(0) = p find n with x(n) = 10\n");
    for (case, first) in [("= 0", "floor((10-p)/v)"), ("> 0", "floor((10-p)/v)+1")] {
        let told = text.split(&format!("and mod(10-p,v) {case}:")).nth(1).unwrap_or_else(|| panic!("{text}"));
        let told = told.split("\n    if ").next().unwrap_or_default();
        assert!(told.contains(&format!("n = {first} is the first with x(n) = 10")), "{text}");
    }
}

/// Against the terms themselves, in machine numbers: what grows in every step does, and closes in on what is said.
#[test]
fn how_a_sequence_moves_is_seen_in_its_terms() {
    type Map = fn(f64) -> f64;
    let maps: [(&str, Map); 12] = [
        ("sqrt(r(n)+2)", |r| (r + 2.0).sqrt()),
        ("sqrt(2*r(n)+3)", |r| (2.0 * r + 3.0).sqrt()),
        ("r(n)/2+sqrt(r(n))/3", |r| r / 2.0 + r.sqrt() / 3.0),
        ("r(n)/(1+r(n)^2)", |r| r / (1.0 + r * r)),
        ("r(n)+1/r(n)", |r| r + 1.0 / r),
        ("(r(n)+2/r(n))/2", |r| f64::midpoint(r, 2.0 / r)),
        ("r(n)+(4-r(n))*abs(4-r(n))/10", |r| r + (4.0 - r) * (4.0 - r).abs() / 10.0),
        ("r(n)-r(n)^3/10", |r| r - r * r * r / 10.0),
        ("r(n)^3/40+r(n)/4+1/5", |r| r * r * r / 40.0 + r / 4.0 + 0.2),
        ("(4*r(n)^2+3/2)/(r(n)^2+8/5)", |r| (4.0 * r * r + 1.5) / (r * r + 1.6)),
        ("sqrt(4*r(n)+2)-1/2", |r| (4.0 * r + 2.0).sqrt() - 0.5),
        ("max(r(n)^2/8+3/2,r(n)-1/10)", |r| (r * r / 8.0 + 1.5).max(r - 0.1)),
    ];
    let mut moved = 0;
    for (map, image) in maps {
        for start in [1i32, 2, 5, 7] {
            let text = solved(map, &start.to_string());
            let Some(line) = text.lines().find(|line| line.contains(" in every step")) else { continue };
            let skipped = line.split("from n = ").nth(1).and_then(|rest| rest.split(' ').next()?.parse::<usize>().ok());
            let mut terms = vec![f64::from(start)];
            for _ in 0..400 {
                terms.push(image(terms[terms.len() - 1]));
            }
            let early = &terms[skipped.unwrap_or(0)..skipped.unwrap_or(0) + 12];
            let grows = line.contains("grows");
            // Near the end machine numbers stand still.
            let apart = |pair: &[f64]| if grows { pair[1] - pair[0] } else { pair[0] - pair[1] };
            assert!(
                early.windows(2).all(|pair| apart(pair) >= 0.0 || !pair[1].is_finite()) && apart(&early[..2]) > 0.0,
                "{map} {start}: {line}"
            );
            let end = terms[400];
            match line.split("the fixed point ").nth(1).and_then(|rest| rest.split(' ').next()) {
                None => assert!(end.abs() > 20.0 || !end.is_finite(), "{map} from {start}: {end}"),
                Some(point) => {
                    let point = number(point);
                    let close = if line.contains('≈') { 1e-5 } else { 1e-9 };
                    assert!((image(point) - point).abs() < close, "{map}: {point} is no fixed point");
                    // Some come slowly: their steps become squares or cubes of what is left.
                    let (left, first) = ((end - point).abs(), (f64::from(start) - point).abs());
                    assert!(left < 0.15 && left < first, "{map} from {start}: {end}, not {point}");
                }
            }
            moved += 1;
        }
    }
    assert!(moved >= 33, "only {moved} move one way");
}

/// Where there is no term any more that is said, in place of dots.
#[test]
fn the_last_term_is_said_to_be_the_last() {
    for (map, first, end) in [
        ("r(n)-1+max(0,sqrt(r(n))-2*r(n))", "3", "r from 0 on: 3, 2, 1, 0, -1; there is no r(5): "),
        ("1/(r(n)-2)+1", "5/2", "r from 0 on: 5/2, 3, 2; there is no r(3): division by zero"),
    ] {
        let text = solved(map, first);
        assert!(text.contains(end), "{map}: {text}");
    }
    // Of two sequences it is the one that has none; what is only too large to compute is not called none.
    let two = told("solve x(n+1) = x(n)^2+1, y(n+1) = 1/(3-n)+x(n)*y(n), x(0) = 1, y(0) = 2\n");
    assert!(two.contains("x from 0 on: 1, 2, 5, 26; there is no y(4): division by zero"), "{two}");
    let large = told("solve u(n+1) = 2^u(n), u(0) = 2\n");
    assert!(large.contains("u from 0 on: 2, 4, 16, ") && !large.contains("there is no"), "{large}");
}

#[test]
fn long_roots_are_told_by_their_digits() {
    let text = solved("sqrt(r(n)+2)", "1");
    let line = text.lines().find_map(|line| line.trim().strip_prefix("r from 0 on: ")).expect("terms");
    let terms: Vec<&str> = line.split(", ").filter(|term| *term != "…").collect();
    assert_eq!(terms.len(), 20);
    assert_eq!(terms[1], "sqrt(3)");
    let mut number = 1.0f64;
    for term in terms {
        if let Some(digits) = term.strip_prefix('≈') {
            assert!((digits.parse::<f64>().expect("digits") - number).abs() < 2e-9, "{term}: {number}");
        }
        number = (number + 2.0).sqrt();
    }
}

/// A phase that comes back several ways has one recurrence, and forms from the start of the run.
#[test]
fn ways_back_are_one_recurrence() {
    let text = told(
        "observer A(x)
proc W_r = (Delay_1 # P_r # A_r) ; In_v<u> ; ((Lss_{r,5} ; W_{r+u}) | (Gte_{r,5} ; W_{r+u/2}))
proc P_r = Out_{p,r} ; P_r
proc C = In_p<r> ; Out_{v,(10-r)/2} ; C
system S = W_0 | C
flow S
",
    );
    for line in [
        "next      r(n+1) = if r(n) < 5 then 1/2*r(n)+5 else 3/4*r(n)+5/2",
        "no closed form: it must be known whether 5-r0 > 0",
        "closed    from r = 0, with which the run begins:",
        "r(0) = 0",
        "r(n) = 10-20/3*(3/4)^n for 1 <= n",
    ] {
        assert!(text.lines().any(|told| told.trim() == line), "{line}\n{text}");
    }
    // 0, 5, 25/4, 115/16, …: by the two maps themselves.
    let mut r = 0.0f64;
    for n in 0..20 {
        let form = if n == 0 { 0.0 } else { 10.0 - 20.0 / 3.0 * 0.75f64.powi(n) };
        assert!((r - form).abs() < 1e-9, "{n}: {r} and {form}");
        r = if r < 5.0 { r / 2.0 + 5.0 } else { 0.75 * r + 2.5 };
    }
}

/// Of a long run the first and last states are told, with long numbers rounded.
#[test]
fn a_long_run_is_told_so_that_it_can_be_read() {
    let text = told(
        "observer At(r)
proc Slow_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; Slow_{r+u}
proc Odo_r = Out_{p,r} ; Odo_r
proc Go = In_p<r> ; Out_{v,(10-r)/100} ; Go
system Near = Slow_0 | Go
prove Near always r <= 9.999 when At_r
",
    );
    assert!(text.contains("refuted: Near always r <= 9.999 when At_r"), "{text}");
    let states: Vec<&str> = text.lines().filter(|line| line.trim().starts_with("at ")).collect();
    assert_eq!(states.len(), 60, "{text}");
    assert!(text.contains("… 858 states more, all as claimed"), "{text}");
    assert!(states[59].contains("at 917: At_{≈9.99900"), "{}", states[59]);
    assert!(text.contains("there r is ≈9.99900"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() < 120), "{text}");
}

/// What leaves a phase is no round of it: then the ways back have no recurrence.
#[test]
fn ways_back_beside_a_way_out_are_none() {
    let text = told(
        "observer A(x)
proc U_x = (Delay_2 # A_x) ; U_{x/2}
proc Z_x = (Delay_1 # A_x) ; ((Lss_{x,10} ; Z_{x+3}) | (Gte_{x,10} ; Lss_{x,20} ; U_x) | (Gte_{x,20} ; Z_{x-1}))
system T = Z_25
flow T
",
    );
    let first = text.split("phase 2:").next().unwrap_or_default();
    assert!(first.contains("f(x) = x-1") && !first.contains("next") && !first.contains("closed"), "{text}");
}

/// Nothing is said of a motion past a jump, however deep it stands, nor from a start that may lie on either side.
#[test]
fn no_motion_is_told_past_a_jump_or_from_an_unknown_side() {
    for (map, first) in [
        ("3/2+3/5*(r(n)-2)+(r(n)-2)^2/10+max(0,r(n)*(if r(n) > 2 then 1 else 0))/4", "3"),
        ("-1/(r(n)+1)+1+max(0,r(n)*(if r(n) > 2 then 1 else 0))*2/3", "3"),
    ] {
        let text = solved(map, first);
        assert!(text.contains("no closed form") && !text.contains("in every step"), "{map}: {text}");
    }
    for map in ["r(n)+(r(n)-1)^2/4", "r(n)+(r(n)-1)^2*(5-r(n))/50"] {
        let text = told(&format!("param a > 0, a < 5, a != 1\nsolve r(n+1) = {map}, r(0) = a\n"));
        assert!(text.contains("no closed form") && !text.contains("in every step"), "{map}: {text}");
    }
}

/// A number with roots that is negative has no root either: nothing is found at a term that does not exist.
#[test]
fn a_negative_number_with_roots_has_no_root() {
    let text = told("solve r(n+1) = sqrt(1-r(n)), r(0) = sqrt(7) find n with r(n) >= 60\n");
    assert!(text.contains("not known whether ever r(n) >= 60") && !text.contains("is the first"), "{text}");
    let text = told(
        "observer A(x)
proc Q_x = (Delay_1 # A_x) ; Q_{sqrt(x-sqrt(7))}
system T = Q_1
prove T always x >= 1 when A_x
",
    );
    assert!(text.contains("could not prove: T always") && text.contains("has no value"), "{text}");
}
