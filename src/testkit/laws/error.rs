//! A law of clusterings: what they lower never rises.

use super::super::{Law, Violation};

/// K-means error never rises: of the total errors of a clustering after each of its steps, none is above
/// the one before it. Both steps of K-means minimise the same sum, so not by one bit.
///
/// Catches: planes by power iteration with the inverse of an indefinite matrix, which finds the
/// eigenvalue of the least magnitude where the least is wanted.
///
/// # Errors
///
/// The first step that raises it.
pub fn error_never_rises(errors: &[f64]) -> Result<(), Violation> {
    let Some(step) = errors.windows(2).position(|pair| pair[1] > pair[0]) else {
        return Ok(());
    };
    let place = format!("after step {}", step + 1);
    let expected = format!("at most {}", errors[step]);
    let found = errors[step + 1];
    Err(Violation::new(
        Law::ErrorNeverRises,
        place,
        "total error",
        expected,
        found,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rise_of_one_bit_is_found() {
        assert_eq!(error_never_rises(&[]), Ok(()));
        assert_eq!(error_never_rises(&[3.0, 2.0, 2.0, 1.0]), Ok(()));
        let risen = error_never_rises(&[3.0, 2.0, 2.0_f64.next_up()]).expect_err("it rises");
        assert_eq!(
            risen.to_string(),
            "K-means error never rises is broken after step 2: total error: expected at most 2, \
             found 2.0000000000000004"
        );
    }
}
