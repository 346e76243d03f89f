//! `pars lint`: what is wrong with the laws of rule files, or only unwise.

use std::path::PathBuf;
use std::rc::Rc;

use crate::lint::report;
use crate::progress::Watch;
use crate::script::{Printer, World, complain, opened};

/// Looks at files; gives the exit code: 0 nothing found, 1 something found, 3 bad input.
pub(super) fn files(paths: &[PathBuf], watch: Rc<Watch>, colour: bool) -> u8 {
    let mut printer = Printer::default();
    let world = World::new(watch);
    let mut code = 0;
    for path in paths {
        let Some(source) = opened(path, colour) else {
            code = 3;
            continue;
        };
        match report(&source, &world, colour) {
            Ok((found, text)) => {
                printer.print(&text);
                code = code.max(u8::from(found));
            }
            Err(why) => {
                complain(&why);
                code = 3;
            }
        }
    }
    code
}
