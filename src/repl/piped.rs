//! A script on standard input that holds commands: what stands between them is run, and they are answered, in order.

use std::rc::Rc;

use super::command;
use super::prompt::Prompt;
use crate::diagnostic::Source;
use crate::progress::Watch;
use crate::report::worse;
use crate::script::{World, complain};

/// Whether a line is a command of the prompt: `:why`. A line of the language never begins so.
fn is_command(line: &str) -> bool {
    line.strip_prefix(':').is_some_and(|rest| rest.starts_with(char::is_alphabetic))
}

/// Whether a text has a line that is a command.
pub fn has_commands(text: &str) -> bool {
    text.lines().any(is_command)
}

/// Runs a text with commands in it; gives the exit code, in which a command that there is not counts as bad input.
pub fn piped(source: &Source, watch: Rc<Watch>, colour: bool) -> u8 {
    let mut prompt = match Prompt::new(Rc::new(World::new(watch.clone())), colour) {
        Ok(prompt) => prompt,
        Err(why) => {
            complain(&why);
            return 3;
        }
    };
    let code = answered(&mut prompt, source);
    if !watch.interrupted() {
        return code;
    }
    complain("interrupted\n");
    worse(code, 4)
}

/// What stands between two commands is one text: names may be used in it before they are declared.
fn answered(prompt: &mut Prompt, source: &Source) -> u8 {
    let mut code = 0;
    let mut items = String::new();
    let mut before = 0;
    for (number, line) in source.text.lines().enumerate() {
        if prompt.stepping() {
            prompt.answer(line);
            before = number + 1;
        } else if is_command(line) {
            code = worse(code, prompt.script(&text_at(source, before, &items)));
            items.clear();
            before = number + 1;
            if !command::known(line) {
                code = worse(code, 3);
            }
            if prompt.answer(line).quit {
                return code;
            }
        } else {
            items.push_str(line);
            items.push('\n');
        }
    }
    worse(code, prompt.script(&text_at(source, before, &items)))
}

/// A part of a text in its own lines: places in it are places in the whole.
fn text_at(source: &Source, line: usize, items: &str) -> Source {
    Source::new(source.name.as_str(), "\n".repeat(line) + items)
}
