//! `pars sweep FILE`: the sweeps of a script, kept point by point.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use indicatif::{ProgressBar, ProgressDrawTarget};

use crate::diagnostic::render_all;
use crate::progress::Watch;
use crate::script::{Printer, World, complain, opened};
use crate::session::{Plan, Plans, Surroundings, cores, plans};
use crate::sweep::store::{self, Store};
use crate::sweep::{Head, Row, hash, region, summary, table};

/// How to run a sweep.
pub(super) struct Request {
    pub(super) output: Option<PathBuf>,
    pub(super) shard: (usize, usize),
    pub(super) jobs: Option<usize>,
}

/// `2/8`
pub(super) fn shard(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(part, parts)| Some((part.parse().ok()?, parts.parse().ok()?)));
    match numbers {
        Some((part, parts)) if (1..=parts).contains(&part) => Ok((part, parts)),
        _ => Err("a part is written `2/8`: the second of eight, the first is 1".to_string()),
    }
}

/// A path with more behind its name.
fn beside(base: &Path, more: &str) -> PathBuf {
    let mut name = base.as_os_str().to_os_string();
    name.push(more);
    PathBuf::from(name)
}

fn base(output: Option<&Path>, file: &Path) -> PathBuf {
    match output {
        Some(output) => output.to_path_buf(),
        None => PathBuf::from(file.file_stem().unwrap_or_else(|| "sweep".as_ref())),
    }
}

/// Runs the sweeps of a script.
pub(super) fn sweep(file: &Path, request: &Request, watch: Rc<Watch>, colour: bool) -> u8 {
    let Some(source) = opened(file, colour) else { return 3 };
    let world = World::new(watch);
    let Plans { plans, failures, texts } =
        plans(&source, &world).unwrap_or_else(|failures| Plans { failures, ..Plans::default() });
    for failure in &failures {
        complain(&render_all(&failure.diagnostics, &failure.source, colour));
    }
    if !failures.is_empty() {
        return 3;
    }
    if plans.is_empty() {
        complain(&format!("`{}` has no sweep: `sweep k in 0 .. 1 step 1/10 {{ … }}`\n", file.display()));
        return 3;
    }
    let base = base(request.output.as_deref(), file);
    let (many, mut worst) = (plans.len() > 1, 0);
    for (number, plan) in plans.iter().enumerate() {
        let own = if many { beside(&base, &format!("-{}", number + 1)) } else { base.clone() };
        let number = (number + 1).to_string();
        let input = hash(texts.iter().map(String::as_str).chain([number.as_str(), crate::sweep::FORMAT]));
        match one(plan, &plan.head(input, request.shard), &own, request, &world) {
            Ok(4) => return 4,
            Ok(code) => worst = worst.max(code),
            Err(why) => {
                complain(&format!("{why}\n"));
                return 2;
            }
        }
    }
    worst
}

fn one(plan: &Plan, head: &Head, base: &Path, request: &Request, world: &World) -> Result<u8, String> {
    let (part, parts) = head.shard;
    let own = if parts == 1 { base.to_path_buf() } else { beside(base, &format!(".{part}of{parts}")) };
    let mut store = Store::open(&beside(&own, ".points.jsonl"), head)?;
    let rest: Vec<usize> = (0..head.points).filter(|point| head.holds(*point) && !store.knows(*point)).collect();
    let bar = ProgressBar::with_draw_target(Some(rest.len() as u64), ProgressDrawTarget::stderr());
    let mut poll = |count: usize| {
        bar.set_position(count as u64);
        world.interrupted()
    };
    plan.run(&rest, request.jobs.unwrap_or_else(cores), &mut poll, &mut |row| store.add(row))?;
    bar.finish_and_clear();
    let rows = store.rows();
    let wanted = (0..head.points).filter(|point| head.holds(*point)).count();
    if rows.len() < wanted {
        complain(&format!("interrupted: {} of {wanted} points are done; the same command goes on\n", rows.len()));
        return Ok(4);
    }
    let mut printer = Printer::default();
    if parts > 1 {
        let file = beside(&own, ".points.jsonl");
        printer.print(&format!("part {part} of {parts}: {} points in {}\n", rows.len(), file.display()));
        return Ok(0);
    }
    write(head, &rows, base, &mut printer)?;
    let mut code = 0;
    for expected in plan.expectations(head, &rows).iter().filter(|expected| !expected.met) {
        printer.print(&format!("  but expected {}\n", expected.text));
        code = 1;
    }
    Ok(code)
}

/// Puts parts together.
pub(super) fn merge(files: &[PathBuf], output: Option<&Path>) -> u8 {
    let mut parts = Vec::new();
    for path in files {
        match store::read(path) {
            Ok((head, rows)) => parts.push((path.display().to_string(), head, rows)),
            Err(why) => {
                complain(&format!("{why}\n"));
                return 3;
            }
        }
    }
    let merged = store::merge(&parts);
    let base = output.map_or_else(|| PathBuf::from("sweep"), Path::to_path_buf);
    match merged.and_then(|(head, rows)| write(&head, &rows, &base, &mut Printer::default())) {
        Ok(()) => 0,
        Err(why) => {
            complain(&format!("{why}\n"));
            3
        }
    }
}

/// Writes the tables and the picture, and says what came out.
fn write(head: &Head, rows: &[Row], base: &Path, printer: &mut Printer) -> Result<(), String> {
    let [values, columns, picture] = [".csv", ".parquet", ".svg"].map(|more| beside(base, more));
    table::write_csv(&values, head, rows)?;
    table::write_parquet(&columns, head, rows)?;
    let drawn = std::fs::write(&picture, region::svg(head, rows));
    drawn.map_err(|error| format!("`{}` cannot be written: {error}", picture.display()))?;
    printer.print(&format!("{}\n", summary(head, rows)));
    for line in region::lines(head, rows) {
        printer.print(&format!("  {line}\n"));
    }
    printer.print(&format!("{}, {}, {}\n", values.display(), columns.display(), picture.display()));
    Ok(())
}
