use pars::diagnostic::{Source, render_all};
use pars::lower::Environment;
use pars::parser::parse_input;
#[test]
fn scratch() {
    let cases = std::fs::read_to_string("/tmp/cases.txt").unwrap();
    for text in cases.split("\n---\n") {
        let source = Source::new("x.pars", text);
        let parsed = parse_input(text);
        println!("=========\n{text}\n{}", render_all(&parsed.diagnostics, &source, false));
        let mut env = Environment::new();
        let seen = env.declare(&parse_input("observer At(r)").items, "");
        assert!(seen[0].is_ok());
        for outcome in env.declare(&parsed.items, text) {
            match outcome {
                Ok(l) => println!("OK {l:?}"),
                Err(e) => println!("{}", render_all(&e, &source, false)),
            }
        }
        for d in env.definitions.iter() {
            println!("{d} {}", d.recursive);
        }
    }
}
