//! Polynomials modulo a small prime: their factors by Berlekamp's method.

/// Coefficients from the constant up, each less than the prime; the last one not 0.
pub(super) type Residues = Vec<u64>;

pub(super) fn trim(mut polynomial: Residues) -> Residues {
    while polynomial.last() == Some(&0) {
        polynomial.pop();
    }
    polynomial
}

pub(super) fn inverse(number: u64, prime: u64) -> u64 {
    let (mut result, mut base, mut exponent) = (1, number % prime, prime - 2);
    while exponent > 0 {
        if exponent % 2 == 1 {
            result = result * base % prime;
        }
        base = base * base % prime;
        exponent /= 2;
    }
    result
}

pub(super) fn monic(polynomial: &[u64], prime: u64) -> Residues {
    let factor = polynomial.last().map_or(1, |lead| inverse(*lead, prime));
    polynomial.iter().map(|coefficient| coefficient * factor % prime).collect()
}

pub(super) fn plus(left: &[u64], right: &[u64], prime: u64) -> Residues {
    let at = |polynomial: &[u64], place: usize| polynomial.get(place).copied().unwrap_or(0);
    trim((0..left.len().max(right.len())).map(|place| (at(left, place) + at(right, place)) % prime).collect())
}

pub(super) fn minus(left: &[u64], right: &[u64], prime: u64) -> Residues {
    let negative: Residues = right.iter().map(|coefficient| (prime - coefficient) % prime).collect();
    plus(left, &negative, prime)
}

pub(super) fn times(left: &[u64], right: &[u64], prime: u64) -> Residues {
    if left.is_empty() || right.is_empty() {
        return Vec::new();
    }
    let mut product = vec![0; left.len() + right.len() - 1];
    for (place, one) in left.iter().enumerate() {
        for (offset, other) in right.iter().enumerate() {
            product[place + offset] = (product[place + offset] + one * other) % prime;
        }
    }
    trim(product)
}

/// Quotient and remainder by a polynomial that is not 0.
pub(super) fn divide(polynomial: &[u64], divisor: &[u64], prime: u64) -> (Residues, Residues) {
    let mut rest = polynomial.to_vec();
    let mut quotient = vec![0; (polynomial.len() + 1).saturating_sub(divisor.len())];
    let factor = divisor.last().map_or(1, |lead| inverse(*lead, prime));
    while rest.len() >= divisor.len() {
        let offset = rest.len() - divisor.len();
        let Some(top) = rest.pop() else { break };
        let top = top * factor % prime;
        quotient[offset] = top;
        for (place, coefficient) in divisor[..divisor.len() - 1].iter().enumerate() {
            rest[offset + place] = (rest[offset + place] + (prime - top) * coefficient) % prime;
        }
    }
    (trim(quotient), trim(rest))
}

/// The monic greatest common divisor.
pub(super) fn common_divisor(left: &[u64], right: &[u64], prime: u64) -> Residues {
    let (mut one, mut two) = (left.to_vec(), right.to_vec());
    while !two.is_empty() {
        let rest = divide(&one, &two, prime).1;
        (one, two) = (two, rest);
    }
    monic(&one, prime)
}

/// `(s, t)` with `s*left + t*right = 1`, for polynomials without common factor.
pub(super) fn combination(left: &[u64], right: &[u64], prime: u64) -> (Residues, Residues) {
    let (mut old, mut new) = (left.to_vec(), right.to_vec());
    let (mut s, mut t) = ((vec![1], Vec::new()), (Vec::new(), vec![1]));
    while !new.is_empty() {
        let (quotient, rest) = divide(&old, &new, prime);
        let next =
            (minus(&s.0, &times(&quotient, &t.0, prime), prime), minus(&s.1, &times(&quotient, &t.1, prime), prime));
        (old, new, s, t) = (new, rest, t, next);
    }
    let scale = old.last().map_or(1, |lead| inverse(*lead, prime));
    let scaled = |polynomial: Residues| polynomial.iter().map(|number| number * scale % prime).collect();
    (scaled(s.0), scaled(s.1))
}

pub(super) fn is_square_free(polynomial: &[u64], prime: u64) -> bool {
    let slope = polynomial.iter().enumerate().skip(1).map(|(place, number)| number * (place as u64 % prime) % prime);
    let slope = trim(slope.collect());
    !slope.is_empty() && common_divisor(polynomial, &slope, prime).len() == 1
}

/// The monic irreducible factors of a monic square-free polynomial.
pub(super) fn factors(polynomial: &[u64], prime: u64) -> Vec<Residues> {
    let basis = fixed_by_frobenius(polynomial, prime);
    let mut found = vec![polynomial.to_vec()];
    for element in basis.iter().filter(|element| element.len() > 1) {
        if found.len() == basis.len() {
            break;
        }
        let mut next = Vec::new();
        for factor in found {
            let mut rest = factor;
            for shift in 0..prime {
                if rest.len() <= 2 {
                    break;
                }
                let part = common_divisor(&rest, &minus(element, &trim(vec![shift]), prime), prime);
                if part.len() > 1 && part.len() < rest.len() {
                    rest = divide(&rest, &part, prime).0;
                    next.push(part);
                } else if part.len() == rest.len() {
                    break;
                }
            }
            next.push(rest);
        }
        found = next;
    }
    found
}

/// A basis of the polynomials v with `v^p = v` modulo a polynomial: as many as it has factors.
fn fixed_by_frobenius(polynomial: &[u64], prime: u64) -> Vec<Residues> {
    let degree = polynomial.len() - 1;
    // Row k: x^(p*k) - x^k.
    let mut rows = Vec::new();
    let mut power: Residues = vec![1];
    for place in 0..degree {
        let mut row: Vec<u64> = (0..degree).map(|at| power.get(at).copied().unwrap_or(0)).collect();
        row[place] = (row[place] + prime - 1) % prime;
        rows.push(row);
        for _ in 0..prime {
            power.insert(0, 0);
            power = divide(&power, polynomial, prime).1;
        }
    }
    null_space(rows, prime)
}

/// The vectors v with `v * rows = 0`.
fn null_space(mut rows: Vec<Vec<u64>>, prime: u64) -> Vec<Residues> {
    let size = rows.len();
    let mut marks: Vec<Vec<u64>> = (0..size).map(|own| (0..size).map(|at| u64::from(at == own)).collect()).collect();
    let mut used = vec![false; size];
    for column in 0..size {
        let Some(pivot) = (0..size).find(|row| !used[*row] && rows[*row][column] != 0) else { continue };
        used[pivot] = true;
        let scale = inverse(rows[pivot][column], prime);
        let (row, mark) = (rows[pivot].clone(), marks[pivot].clone());
        for other in (0..size).filter(|other| *other != pivot) {
            let factor = (prime - rows[other][column] * scale % prime) % prime;
            if factor != 0 {
                for at in 0..size {
                    rows[other][at] = (rows[other][at] + factor * row[at]) % prime;
                    marks[other][at] = (marks[other][at] + factor * mark[at]) % prime;
                }
            }
        }
    }
    marks.into_iter().zip(used).filter(|(_, used)| !used).map(|(mark, _)| trim(mark)).collect()
}
