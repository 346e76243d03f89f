//! `pars report FILE`: what came of a script as a page.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::diagnostic::{Source, render_all};
use crate::page::Page;
use crate::progress::Watch;
use crate::report::worse;
use crate::script::{Printer, World, complain, opened};
use crate::session::{Session, Surroundings};

/// The world of a report: with pictures, and every text that was read is kept.
struct Pictured {
    world: World,
    texts: RefCell<Vec<(String, String)>>,
}

impl Surroundings for Pictured {
    fn find(&self, importer: &str, path: &str) -> Result<Source, String> {
        let keep = |found: &Source| self.texts.borrow_mut().push((found.name.to_string(), found.text.to_string()));
        self.world.find(importer, path).inspect(keep)
    }

    fn interrupted(&self) -> bool {
        self.world.interrupted()
    }

    fn pictures(&self) -> bool {
        true
    }

    fn begins(&self, what: &str) {
        self.world.begins(what);
    }

    fn ends(&self) {
        self.world.ends();
    }
}

/// Writes the page of a script, or prints it; the exit code of the script.
pub(super) fn report(file: &Path, output: Option<&Path>, terminal: bool, watch: Rc<Watch>, colour: bool) -> u8 {
    let Some(source) = opened(file, colour) else { return 3 };
    let world = Rc::new(Pictured { world: World::new(watch.clone()), texts: RefCell::default() });
    let mut session = match Session::new(world.clone()) {
        Ok(session) => session,
        Err(failures) => {
            for failure in failures {
                complain(&render_all(&failure.diagnostics, &failure.source, colour));
            }
            return 3;
        }
    };
    let mut outputs = Vec::new();
    session.run(&source, &mut |output, _| outputs.push(output.clone()));
    let mut code = outputs.iter().fold(0, |code, output| worse(code, output.exit_code()));
    if watch.interrupted() {
        complain("interrupted\n");
        code = worse(code, 4);
    }
    let mut texts = vec![(source.name.to_string(), source.text.to_string())];
    texts.extend(world.texts.borrow().iter().cloned());
    let laws = &session.environment().laws;
    let page = Page { title: format!("Report on {}", source.name), texts, outputs, laws };
    let mut printer = Printer::default();
    if terminal {
        printer.print(&page.terminal(colour));
        return code;
    }
    let stem = PathBuf::from(file.file_stem().unwrap_or_else(|| "report".as_ref()));
    let mut base = output.map_or(stem, Path::to_path_buf);
    if base.extension().is_some_and(|more| more == "html" || more == "md") {
        base.set_extension("");
    }
    for (more, text) in [(".html", page.html()), (".md", page.markdown())] {
        let mut name = base.as_os_str().to_os_string();
        name.push(more);
        let path = PathBuf::from(name);
        if let Err(error) = std::fs::write(&path, text) {
            complain(&format!("`{}` cannot be written: {error}\n", path.display()));
            return 2;
        }
        printer.print(&format!("{}\n", path.display()));
    }
    code
}
