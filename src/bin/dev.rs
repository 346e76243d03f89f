use pars::diagnostic::{render_all, Source};
use pars::kernel::Theory;
use pars::lower::{By as LBy, ClaimKind, Environment, Lowered};
use pars::proof::Statement;
use pars::prove::{Answer, By, prove};
fn load(env: &mut Environment, name: &str) -> Vec<Lowered> {
    let text = std::fs::read_to_string(name).unwrap();
    let parsed = pars::parser::parse(&text);
    let source = Source::new(name, text.clone());
    if !parsed.diagnostics.is_empty() { println!("{}", render_all(&parsed.diagnostics, &source, false)); }
    let mut out = vec![];
    for r in env.declare(&parsed.items, &text) { match r { Ok(l) => out.push(l), Err(d) => println!("{}", render_all(&d, &source, false)) } }
    out
}
fn main() {
    std::thread::Builder::new().stack_size(1<<30).spawn(|| {
    let mut env = Environment::new();
    for f in ["sequence","parallel","disable","delay","observe","condition","loop","port"] { load(&mut env, &format!("rules/{f}.rules")); }
    println!("{} laws", env.laws.iter().count());
    let only: Option<String> = std::env::args().nth(2);
    let claims = load(&mut env, &std::env::args().nth(1).unwrap());
    let (mut ok, mut open) = (0,0);
    for c in claims { if let Lowered::Claim(c) = c { if let ClaimKind::Compare{left,right,connective,when,by} = c.kind {
        let name = c.name.map(|n| n.to_string()).unwrap_or_default();
        if let Some(o) = &only { if *o != name { continue } }
        let theory = Theory { assumptions: env.assumptions.clone(), definitions: env.definitions.clone(), laws: env.laws.clone() };
        let st = Statement{hypotheses: when, left: left.clone(), connective, right: right.clone()};
        let LBy::Search = by else { println!("by.."); continue };
        let t = std::time::Instant::now();
        match prove(&theory, &st, &By::Search, Default::default(), &|| false) {
            Answer::Proved(t2, p) => { ok += 1; println!("{name:8} proved {:?} steps {} laws {:?}", t.elapsed(), p.steps.len(), t2.laws()) }
            Answer::Open(g) => { open += 1; println!("{name:8} OPEN {:?} {:?} {:?}\n     {}\n  => {}\n  => {}", t.elapsed(), g.ended, g.size, c.text, g.left, g.right); if let Some(r)=g.rejected { println!("REJECTED {r:?}") } }
        }
    }}}
    println!("{ok} proved {open} open");
    }).unwrap().join().unwrap();
}
