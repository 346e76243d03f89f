//! Ways through rounds as edges of the graph, over the variables of the phases that they reach.

use std::collections::BTreeMap;

use super::super::held::Held;
use super::super::run::{Env, RawTest};
use super::super::{Edge, Failure, Next, Test};
use super::{Explorer, Target, Way};
use crate::name::Name;
use crate::value::Value;

impl Explorer<'_> {
    pub(super) fn edge(&self, way: &Way) -> Result<Edge, Failure> {
        let mut map = BTreeMap::new();
        let next = match &way.next {
            Target::End(end) => Next::End(end.clone()),
            Target::Spot(number, entries) => {
                let spot = &self.spots[*number];
                for (held, entry) in spot.held.iter().zip(entries) {
                    if let Held::Class(class) = held {
                        map.insert(spot.variables[*class].clone(), entry.clone());
                    }
                }
                Next::Phase(*number)
            }
        };
        let after = way.tests.iter().map(|test| self.after(test, &map)).collect();
        Ok(Edge {
            tests: way.tests.iter().map(|test| test.test.clone()).collect(),
            after,
            segments: way.segments.clone(),
            map,
            communications: way.communications.clone(),
            draws: way.draws.clone(),
            switches: way.switches,
            next,
        })
    }

    /// A test said over the variables that the round leads to.
    fn after(&self, test: &RawTest, map: &BTreeMap<Name, Value>) -> Option<Test> {
        let mut renamed = Env::new();
        for (name, value) in test.env.iter() {
            let image = |value: &Value| {
                let known = map.iter().find(|(_, image)| *image == value).map(|(name, _)| Value::variable(name));
                known.or_else(|| (!self.clock.settler.varies(value)).then(|| value.clone()))
            };
            let value = match value.components() {
                None => image(value)?,
                Some(parts) => Value::vector(parts.iter().map(image).collect::<Option<_>>()?).ok()?,
            };
            renamed.insert(name.clone(), value);
        }
        test.raw.substitute(&renamed).ok()
    }
}
