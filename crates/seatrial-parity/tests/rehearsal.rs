//! The rehearsal is worth comparing: it runs a trial to its end, through every kind of bad sample, to the truth.

use seatrial_parity::{Bits, Table, write};

fn table<T: Bits>(table: Table) -> Vec<Vec<String>> {
    let mut text = String::new();
    write::<T>(table, &mut text).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn column(rows: &[Vec<String>], name: &str) -> usize {
    rows[0].iter().position(|column| column == name).unwrap()
}

fn recovers<T: Bits>(number: impl Fn(&str) -> f64) {
    for kind in [Table::Trial, Table::Estimator] {
        let rows = table::<T>(kind);
        assert!(rows.iter().all(|row| row.len() == rows[0].len()));
        let first = column(&rows, "a22_per_s");
        // At thrust 0.9: u = 1.8 m/s, b2 = 0.42 u^2.
        let truth = [-1.07, 0.42 * 1.8 * 1.8, 0.012];
        for (field, truth) in rows.last().unwrap()[first..].iter().zip(truth) {
            // Compass noise of 2 mrad leaves 0.1 %.
            assert!((number(field) / truth - 1.0).abs() < 0.005, "{field}");
        }
    }
    let trial = table::<T>(Table::Trial);
    let outcome = column(&trial, "outcome");
    assert_eq!(trial.last().unwrap()[outcome], "finished");
    let estimator = table::<T>(Table::Estimator);
    for word in ["used", "warming", "rejected"] {
        assert!(estimator.iter().any(|row| row.iter().any(|f| f == word)));
    }
}

fn double(field: &str) -> f64 {
    f64::from_bits(u64::from_str_radix(field, 16).unwrap())
}

fn single(field: &str) -> f64 {
    f32::from_bits(u32::from_str_radix(field, 16).unwrap()).into()
}

#[test]
fn recover_the_rehearsals_vehicle_f64() {
    recovers::<f64>(double);
}

#[test]
fn recover_the_rehearsals_vehicle_f32() {
    recovers::<f32>(single);
}

#[test]
fn parity_f32_ends_where_f64_does() {
    for kind in Table::ALL {
        let (doubles, singles) = (table::<f64>(kind), table::<f32>(kind));
        let first = column(&doubles, "a22_per_s");
        let last = |rows: &[Vec<String>]| rows.last().unwrap()[first..first + 3].to_vec();
        for (expected, found) in last(&doubles).iter().zip(last(&singles)) {
            // A heading of 3 rad in f32 resolves 2e-7 rad; filters and 330 updates raise that to 5e-5 of C0.
            assert!((single(&found) / double(expected) - 1.0).abs() < 1e-4);
        }
    }
}
