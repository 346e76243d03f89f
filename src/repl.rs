//! The prompt: a line editor around a session.
//!
//! What is typed is answered by [`Prompt`], which needs no terminal; this file alone knows the line editor.

mod command;
mod help;
mod helper;
mod piped;
mod prompt;
mod waiting;

use std::path::PathBuf;
use std::rc::Rc;

use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{CompletionType, Config, Editor};

use crate::progress::Watch;
use crate::script::{Printer, World, complain};
use crate::walk::Walk;

use helper::Assistant;
pub use piped::{has_commands, piped};
pub use prompt::{Prompt, Reply};

const GREETING: &str = "PARS: processes, laws, proofs. `:help` tells what can be typed, Ctrl-D leaves.\n";

/// Runs the prompt until the user leaves it; gives the exit code.
pub fn run(watch: Rc<Watch>, colour: bool) -> u8 {
    let mut prompt = match Prompt::new(Rc::new(World::new(watch.clone())), colour) {
        Ok(prompt) => prompt,
        Err(why) => {
            complain(&why);
            return 3;
        }
    };
    let config = Config::builder()
        .completion_type(CompletionType::List)
        .history_ignore_space(true)
        .bracketed_paste(true)
        .tab_stop(4)
        .build();
    let mut editor: Editor<Assistant, FileHistory> = match Editor::with_config(config) {
        Ok(editor) => editor,
        Err(error) => {
            complain(&format!("the terminal cannot be used: {error}\n"));
            return 2;
        }
    };
    editor.set_helper(Some(Assistant::new(colour)));
    let history = history_file();
    if let Some(path) = &history {
        // The first time there is none.
        let _ = editor.load_history(path);
    }
    prompt.print(GREETING);
    turns(&mut editor, &mut prompt, &watch);
    if let Some(path) = &history
        && let Err(error) = editor.save_history(path)
    {
        complain(&format!("the history cannot be kept in `{}`: {error}\n", path.display()));
    }
    0
}

/// One input after the other.
fn turns(editor: &mut Editor<Assistant, FileHistory>, prompt: &mut Prompt, watch: &Watch) {
    loop {
        if let Some(helper) = editor.helper_mut() {
            helper.learn(prompt.session(), prompt.stepping());
        }
        match editor.readline(prompt.sign()) {
            Ok(line) => {
                let _ = editor.add_history_entry(line.as_str());
                watch.reset();
                let reply = prompt.answer(&line);
                watch.reset();
                if reply.quit {
                    return;
                }
            }
            Err(ReadlineError::Interrupted) => watch.reset(),
            Err(ReadlineError::Eof) => return,
            Err(ReadlineError::Signal(_)) => {}
            Err(error) => {
                complain(&format!("the terminal cannot be read: {error}\n"));
                return;
            }
        }
    }
}

/// Steps a process until the user leaves it; gives the exit code.
pub fn walk(mut walk: Walk, colour: bool) -> u8 {
    let mut printer = Printer::default();
    printer.print(&format!("{}`help` lists what can be typed, Ctrl-D leaves.\n", walk.opening()));
    ask("step> ", colour, &mut |line| {
        let answer = walk.answer(line);
        printer.print(&answer.text);
        answer.quit.then_some(0)
    })
    .unwrap_or(0)
}

/// Asks for one line after the other until `take` has a result; none when the user leaves before.
pub fn ask<T>(prompt: &str, colour: bool, take: &mut dyn FnMut(&str) -> Option<T>) -> Option<T> {
    let mut editor: Editor<Assistant, FileHistory> = match Editor::new() {
        Ok(editor) => editor,
        Err(error) => {
            complain(&format!("the terminal cannot be used: {error}\n"));
            return None;
        }
    };
    editor.set_helper(Some(Assistant::for_steps(colour)));
    loop {
        match editor.readline(prompt) {
            Ok(line) => {
                let _ = editor.add_history_entry(line.as_str());
                if let Some(result) = take(&line) {
                    return Some(result);
                }
            }
            Err(ReadlineError::Eof) => return None,
            Err(ReadlineError::Interrupted | ReadlineError::Signal(_)) => {}
            Err(error) => {
                complain(&format!("the terminal cannot be read: {error}\n"));
                return None;
            }
        }
    }
}

/// Where what was typed is kept: in the user's folder for such things.
fn history_file() -> Option<PathBuf> {
    let given = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state = given("XDG_STATE_HOME")
        .or_else(|| given("HOME").map(|home| home.join(".local/state")))
        .or_else(|| given("LOCALAPPDATA"))?;
    let folder = state.join("pars");
    std::fs::create_dir_all(&folder).ok()?;
    Some(folder.join("history"))
}
