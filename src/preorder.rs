//! The preorders, equivalences among them, by which two systems may be compared, by name.

/// What two systems may be compared by; an equivalence is a preorder that holds both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Preorder {
    /// Strong bisimilarity.
    Strong,
    /// Weak bisimilarity in which endings are compared exactly.
    Weak,
    /// Branching bisimilarity, likewise.
    Branching,
    /// The same traces; an internal step counts as a step.
    Trace,
    /// The same traces; internal steps do not count.
    WeakTrace,
    /// Whatever the left does, the right can do too: a preorder.
    Simulation,
    /// Each simulates the other.
    SimulationEquivalence,
    /// As strong bisimilarity, but the right may show fewer observers: a preorder.
    Refinement,
}

impl Preorder {
    /// All of them with their names.
    pub const ALL: [(Preorder, &'static str); 8] = [
        (Preorder::Strong, "strong"),
        (Preorder::Weak, "weak"),
        (Preorder::Branching, "branching"),
        (Preorder::Trace, "trace"),
        (Preorder::WeakTrace, "weak-trace"),
        (Preorder::Simulation, "simulation"),
        (Preorder::SimulationEquivalence, "simulation-equivalence"),
        (Preorder::Refinement, "refinement"),
    ];

    /// The relation of this name.
    pub fn of(name: &str) -> Option<Preorder> {
        Preorder::ALL.iter().find(|(_, known)| *known == name).map(|(relation, _)| *relation)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Preorder::ALL.iter().find(|(relation, _)| *relation == self).map_or("", |(_, name)| name)
    }

    /// What an answer of yes or no says.
    pub fn says(self, yes: bool) -> &'static str {
        match (self, yes) {
            (Preorder::Strong, true) => "strongly bisimilar",
            (Preorder::Strong, false) => "not strongly bisimilar",
            (Preorder::Weak, true) => "weakly bisimilar, endings exact",
            (Preorder::Weak, false) => "not weakly bisimilar, endings exact",
            (Preorder::Branching, true) => "branching bisimilar",
            (Preorder::Branching, false) => "not branching bisimilar",
            (Preorder::Trace, true) => "the same traces",
            (Preorder::Trace, false) => "not the same traces",
            (Preorder::WeakTrace, true) => "the same traces up to internal steps",
            (Preorder::WeakTrace, false) => "not the same traces up to internal steps",
            (Preorder::Simulation, true) => "the right side simulates the left",
            (Preorder::Simulation, false) => "the right side does not simulate the left",
            (Preorder::SimulationEquivalence, true) => "each side simulates the other",
            (Preorder::SimulationEquivalence, false) => "one side does not simulate the other",
            (Preorder::Refinement, true) => "the right side does the same and shows no more",
            (Preorder::Refinement, false) => "the right side does something else or shows more",
        }
    }

    /// Whether it compares traces alone.
    pub fn is_trace(self) -> bool {
        matches!(self, Preorder::Trace | Preorder::WeakTrace)
    }

    /// Whether internal steps do not count.
    pub fn is_weak(self) -> bool {
        matches!(self, Preorder::Weak | Preorder::Branching | Preorder::WeakTrace)
    }
}
