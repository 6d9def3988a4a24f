//! Files in which any number stands in the place of each number.

use toml::{Table, Value};

/// Ends of ranges, tiny and huge numbers, and what is no number.
const NUMBERS: [f64; 13] = [
    0.0,
    -1.0,
    1e-300,
    5e-324,
    1e-9,
    1e3,
    1e9,
    1e300,
    -1e300,
    f64::MAX,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// The table with one number after the other in the place of each of its own, one at a time.
pub fn with_any_number(table: &Table) -> Vec<Table> {
    let mut changed = Vec::new();
    for (name, value) in table {
        for other in instead_of(value) {
            let mut table = table.clone();
            table.insert(name.clone(), other);
            changed.push(table);
        }
    }
    changed
}

fn instead_of(value: &Value) -> Vec<Value> {
    match value {
        Value::Float(_) => NUMBERS.into_iter().map(Value::Float).collect(),
        Value::Integer(_) => [0, 1, -1, i64::MAX, i64::MIN].map(Value::Integer).to_vec(),
        Value::Table(table) => with_any_number(table).into_iter().map(Value::Table).collect(),
        Value::Array(values) => (0..values.len())
            .flat_map(|k| {
                let with = move |other| {
                    let mut values = values.clone();
                    values[k] = other;
                    Value::Array(values)
                };
                instead_of(&values[k]).into_iter().map(with)
            })
            .collect(),
        _ => Vec::new(),
    }
}
