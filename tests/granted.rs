//! What must hold for an answer of `solve` to mean something is said: of what an equation divides by and takes the root of,
//! also where that has cancelled or stands inside; first values that the equation would not make; and of what it is expected.

mod common;

use common::ran;

/// The lines that the program says to a script, without what stands before them.
fn told(script: &str) -> Vec<String> {
    let text = String::from_utf8_lossy(&ran(script).stdout).into_owned();
    text.lines().map(|line| line.trim().to_string()).collect()
}

#[track_caller]
fn says(script: &str, wanted: &[&str]) {
    let told = told(script);
    for line in wanted {
        assert!(told.iter().any(|other| other == line), "not said: {line}\n{}", told.join("\n"));
    }
}

#[test]
fn a_divisor_inside_of_an_integer_part_or_a_maximum_is_a_condition() {
    says("param M\nsolve x(n+1) = x(n)+floor(7/M), x(0) = 0\n", &["x(n) = n*floor(7/M)", "if M != 0"]);
    says("param M\nsolve x(n+1) = min(x(n)+1,floor(7/M)), x(0) = 0\n", &["if M != 0"]);
    says("solve x(n+1) = x(n)+floor(1/100/(n-7)), x(0) = 0\n", &["no closed form is known: it divides by 0 at n = 7"]);
    says("solve x(n+1) = x(n)+floor(7/(n+1)), x(0) = 0\n", &["x(n) = sum(k=0..n-1, floor(7/(k+1)))"]);
}

#[test]
fn what_cancels_of_parameters_is_a_condition() {
    says("param M\nsolve x(n+1) = x(n)+max(1,-1/M^2), x(0) = 0\n", &["x(n) = n", "if M != 0"]);
    says("param a\nsolve x(n+1) = x(n)+sqrt(a)-sqrt(a), x(0) = 0\n", &["x(n) = 0", "if a >= 0"]);
    says("param v\nsolve r(n+1) = r(n)/v*v+1, r(0) = v/v find n with r(n) >= 10\n", &["r(n) = n+1", "if v != 0"]);
    let told = told("param v > 0\nsolve r(n+1) = r(n)/v*v+1, r(0) = v/v\n");
    assert!(!told.iter().any(|line| line.starts_with("if ")), "{}", told.join("\n"));
    says(
        "param k\nsolve r(n+1) = r(n)+1, r(0) = 0 find n with r(n)/k*k >= 3 and n = 7\n",
        &["if k != 0", "n = 7 is the first with r(n)/k*k >= 3 and n = 7"],
    );
}

#[test]
fn what_an_answer_in_cases_needs_stands_before_its_cases() {
    let question = |rest: &str| format!("param a, M\nsolve x(n+1) = x(n)+{rest} find n with x(n) >= 3\n");
    let before_its_cases = |rest: &str| {
        let lines = told(&question(rest));
        let need = lines.iter().position(|line| line == "if M != 0");
        let case = lines.iter().position(|line| line.ends_with(':'));
        assert!(need.is_some() && case.is_none_or(|case| need < Some(case)), "{rest}\n{}", lines.join("\n"));
        lines
    };
    let lines = before_its_cases("abs(1/M), x(0) = 0");
    for line in ["if M > 0:", "if M < 0:", "in every order: n = ceil(3*abs(M)) is the first with x(n) >= 3"] {
        assert!(lines.iter().any(|other| other == line), "not said: {line}\n{}", lines.join("\n"));
    }
    for rest in ["abs(a/M), x(0) = 0", "max(1,a/M), x(0) = 0"] {
        before_its_cases(rest);
    }
}

#[test]
fn what_one_branch_divides_by_is_not_asked_in_the_other() {
    let script = "param k\nsolve x(n+1) = x(n)+(if k < 0 then 1/k else 1), x(0) = 0 find n with x(n) >= 5\n";
    says(script, &["if k < 0:", "x(n) = n/k", "if k >= 0:", "n = 5 is the first with x(n) >= 5"]);
    assert!(!told(script).iter().any(|line| line.contains("k != 0")), "{}", told(script).join("\n"));
    // For every b above 1 one index: at 3/2 it is 1.
    let script = "param b\nsolve x(n+1) = if b != 1 and n < 3 then x(n)+2/(b-1) else x(n)+1, x(0) = 1 \
                  find n with b = 1 or x(n) >= 2/(b-1)\n";
    let found = told(script);
    let firsts: Vec<&String> = found.iter().filter(|line| line.contains(" is the first")).collect();
    assert_eq!(firsts.len(), 4, "in two orders, in both together, and where b = 1:\n{}", found.join("\n"));
    assert!(firsts[0].starts_with("n = max(2-floor(1/2*b+1/2),0) is"), "{}", found.join("\n"));
}

#[test]
fn a_sum_of_roots_is_a_form_where_each_root_has_a_value() {
    says("solve x(n+1) = x(n)+sqrt(n^2-10*n+30), x(0) = 0\n", &["x(n) = sum(k=0..n-1, sqrt(k^2-10*k+30))"]);
    says("param p\nsolve x(n+1) = x(n)+sqrt(n+p), x(0) = 0\n", &["x(n) = sum(k=0..n-1, sqrt(k+p))", "if p >= 0"]);
    for (step, reason) in [
        ("sqrt(10-n)", "it takes the root of 10-n, which is negative from some n on"),
        ("sqrt(n-10)", "it takes the root of -10 at n = 0"),
        ("sqrt(n^2-10*n+5)", "it must be known whether n^2-10*n+5 is ever negative"),
        ("floor(sqrt(10-n))", "it takes the root of 10-n, which is negative from some n on"),
    ] {
        let line = format!("no closed form is known: {reason}");
        says(&format!("solve x(n+1) = x(n)+{step}, x(0) = 0\n"), &[&line]);
    }
    says("solve x(n+1) = x(n)+(if n < 10 then sqrt(10-n) else 0)-x(n), x(0) = 0\n", &["x(n) = 0 for 11 <= n"]);
}

#[test]
fn first_values_that_the_equation_would_not_make_are_told() {
    says(
        "solve r(n+1) = r(n)+1, r(0) = 0, r(1) = 5\n",
        &[
            "r(1) = 5 is given, where the equation makes it 1: it is taken to hold from r(2) on",
            "r(n) = n+4 for 1 <= n",
        ],
    );
    says(
        "param p\nsolve x(n+1) = x(n)+y(n), y(n+1) = y(n)+1, x(0) = 0, x(1) = p, y(0) = 0\n",
        &["x(1) = p is given, where the equation makes it 0: it is taken to hold from x(2) on"],
    );
    for given in ["r(n+1) = r(n)+1, r(0) = 0, r(1) = 1", "r(n+2) = r(n+1)+r(n), r(0) = 0, r(1) = 7"] {
        let told = told(&format!("solve {given}\n"));
        assert!(!told.iter().any(|line| line.contains("is given")), "{}", told.join("\n"));
    }
}

#[test]
fn what_is_expected_of_a_question_with_an_error_is_expected_of_nothing_else() {
    for script in [
        "prove Delay_1 ; Delay_2 = Delay_3\nexpect proved\nprove Delay_q = Delay_3\nexpect refuted\nexpect open\n",
        "prove Delay_1 ; Delay_2 = Delay_3\nsolve r(n+1) = r(n +, r(0) = 0\nexpect open\n",
        "prove Delay_1 = Delay_1\nproc P_r = Delay_1 ; Q_r\nproc D = P_{1}\nsystem S = D\nperiod S\nexpect yes\n",
    ] {
        let output = ran(script);
        let all = [output.stdout, output.stderr].concat();
        let all = String::from_utf8_lossy(&all);
        assert!(all.contains("error["), "{all}");
        assert!(!all.contains("but expected") && !all.contains("P0901"), "{all}");
    }
    // What was asked last is asked for, though something else was declared since.
    assert!(
        told("prove Delay_1 = Delay_1\nparam x\nexpect refuted\n").iter().any(|line| line == "but expected refuted")
    );
}

/// The lines of the answer, with how far they are indented, below the question.
fn laid_out(script: &str) -> String {
    let text = String::from_utf8_lossy(&ran(script).stdout).into_owned();
    let lines = text.lines().filter_map(|line| line.strip_prefix("    "));
    lines.filter(|line| !line.trim_start().starts_with("checked")).collect::<Vec<_>>().join("\n")
}

#[test]
fn forms_that_are_the_same_in_each_case_stand_once() {
    let script = "param a, b\nsolve x(n+1) = x(n)+1, x(0) = 0 find n with a = b or x(n) > 5\n";
    let goal = "is the first with a = b or x(n) > 5";
    let wanted = format!("x(n) = n\nif b != a:\n  n = 6 {goal}\nif b = a:\n  n = 0 {goal}");
    assert_eq!(laid_out(script), wanted);
    // Where they differ each case has its own, and what it needs.
    let script = "param a, b\nsolve x(n+1) = if a > 0 then x(n)/b else x(n)+1, x(0) = 0 find n with x(n) > 7\n";
    let wanted = "if a > 0:\n  x(n) = 0\n  if b != 0\n  never x(n) > 7: it stays 0\n\
                  if a <= 0:\n  x(n) = n\n  n = 8 is the first with x(n) > 7";
    assert_eq!(laid_out(script), wanted);
}

#[test]
fn the_cases_are_those_of_names() {
    let titles = |script: &str| {
        let text = laid_out(script);
        text.lines().map(str::trim).filter(|line| line.ends_with(':')).map(String::from).collect::<Vec<_>>().join(" ")
    };
    let script = "param a\nsolve x(n+1) = x(n)+1, x(0) = 0 find n with a > 1 and x(n) = a/(a-1) or x(n) > 3\n";
    let own = "if a < 4/3: if a >= 4/3 and mod(1,1-a) = 0: if a >= 4/3 and mod(1,1-a) < 0:";
    assert_eq!(titles(script), format!("if a > 1: {own} if a <= 1:"));
    // Each of them is answered: 1+1/(a-1) where that is whole and at most 4.
    says(script, &["n = ceil(1/(a-1))+1 is the first with a > 1 and x(n) = a/(a-1) or x(n) > 3"]);
    // What is asked falls with n where k < 0, so it is first at 0, or never: one condition, no further case.
    let script = "param k\nsolve x(n+1) = x(n)+1, x(0) = k find n with k < 0 and x(n)*k > 1 and x(n) < 6\n";
    assert_eq!(titles(script), "if k < 0: if k >= 0:");
    says(script, &["n = 0 is the first with k < 0 and x(n)*k > 1 and x(n) < 6", "if k^2 > 1", "else never"]);
}

#[test]
fn a_reason_within_a_piece_says_from_where_it_counts() {
    let script = "solve x(n+1) = if x(n) < 3 then x(n)+1 else x(n)-1/(n-7), x(0) = 0\n";
    let line = "no closed form is known: from n = 3 on, with n counted from there: it divides by 0 at n = 4";
    says(script, &[line, "x from 0 on: 0, 1, 2, 3, 13/4, 43/12, 49/12, 61/12; there is no x(8): division by zero"]);
}

#[test]
fn a_power_by_what_is_rounded_up_is_not_bounded() {
    // 2^ceil(b) is a power of 1/2 by floor(-b), which is not positive: it is at least 1, and 8 at b = 3.
    let script = "param b >= 0\nsolve x(n+1) = x(n)*2, x(0) = 1 find n with n >= b and x(n) < 5\n";
    says(script, &["n = ceil(b) is the first with n >= b and x(n) < 5", "if 5-(1/2)^floor(-b) > 0", "else never"]);
    let script = "param b >= 0\nsolve x(n+1) = x(n)+1, x(0) = 2^ceil(b) find n with x(n) < 5\n";
    assert!(told(script).iter().any(|line| line.ends_with(" = 0:")), "{}", told(script).join("\n"));
}

#[test]
fn a_power_by_what_is_rounded_down_may_be_no_integer() {
    // 2^floor(b) is 1/4 at b = -3/2, and rounded down 0.
    says("param b\nsolve x(n+1) = x(n)+1, x(0) = floor(2^floor(b))\n", &["x(n) = n+floor(2^floor(b))"]);
    says("param k : natural\nsolve x(n+1) = x(n)+1, x(0) = floor(2^k)\n", &["x(n) = n+2^k"]);
}

#[test]
fn an_exponent_is_taken_to_be_natural_and_that_is_said() {
    let note = "k is taken to be a natural number: it is an exponent";
    says("param k\nsolve x(n+1) = x(n)+1, x(0) = 2^k\n", &[note, "x(n) = n+2^k"]);
    let script = "param k : natural\nsolve x(n+1) = x(n)+1, x(0) = 2^k\n";
    assert!(!told(script).iter().any(|line| line == note), "{}", told(script).join("\n"));
}
