//! Names of columns and units as words.

/// Lower-case words: split at anything that is no letter or digit and where camelCase rises.
pub(crate) fn words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let characters: Vec<char> = text.chars().collect();
    for (i, &c) in characters.iter().enumerate() {
        let before = i.checked_sub(1).and_then(|i| characters.get(i));
        let after = characters.get(i + 1);
        let rises = c.is_uppercase()
            && (before.is_some_and(|b| b.is_lowercase() || b.is_ascii_digit())
                || (before.is_some_and(|b| b.is_uppercase())
                    && after.is_some_and(|a| a.is_lowercase())));
        let symbol = match c {
            '°' => Some("deg"),
            '%' => Some("percent"),
            'ψ' => Some("psi"),
            'δ' => Some("delta"),
            'φ' => Some("phi"),
            'θ' => Some("theta"),
            _ => None,
        };
        if rises || !c.is_alphanumeric() || symbol.is_some() {
            words.push(String::new());
        }
        let word = words.last_mut().expect("starts with one word");
        match symbol {
            Some(symbol) => {
                word.push_str(symbol);
                words.push(String::new());
            }
            None if c.is_alphanumeric() => word.extend(c.to_lowercase()),
            None => {}
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Is it one of the words of a text?
pub(crate) fn is_among(text: &str, word: &str) -> bool {
    text.split_ascii_whitespace().any(|known| known == word)
}
