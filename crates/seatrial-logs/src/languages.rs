//! Names of columns in German and Japanese.

use crate::Quantity;

/// What a quantity is called in other languages, lower case without separators.
pub(crate) struct Names {
    /// Words that mean the quantity and nothing else.
    pub clear: &'static [&'static str],
    /// Words that mean the quantity or something near it: a command, a course, a speed over ground.
    pub vague: &'static [&'static str],
}

/// The names of a quantity in German and Japanese.
pub(crate) fn names(quantity: Quantity) -> Names {
    let (clear, vague): (&[&str], &[&str]) = match quantity {
        Quantity::Time => (
            &["zeit", "時刻", "時間", "経過時間"],
            &["zeitstempel", "sekunden", "uhrzeit", "日時"],
        ),
        Quantity::Heading => (
            &[
                "steuerkurs",
                "gierwinkel",
                "船首方位",
                "船首方位角",
                "ヨー角",
                "方位角",
            ],
            &[
                "kompasskurs",
                "kompass",
                "kurs",
                "kurswinkel",
                "方位",
                "針路",
                "回頭角",
                "ヨー",
            ],
        ),
        Quantity::Rudder => (
            &[
                "ruder",
                "ruderwinkel",
                "ruderlage",
                "ruderausschlag",
                "舵角",
                "実舵角",
            ],
            &[
                "ruderkommando",
                "rudersollwinkel",
                "指令舵角",
                "命令舵角",
                "舵",
            ],
        ),
        Quantity::Speed => (
            &[
                "fahrt",
                "fahrtdurchswasser",
                "fdw",
                "längsgeschwindigkeit",
                "船速",
                "対水速度",
            ],
            &[
                "geschwindigkeit",
                "fahrtübergrund",
                "füg",
                "速度",
                "対地速度",
                "速力",
            ],
        ),
        Quantity::Depth => (&["tiefe", "tauchtiefe", "深度"], &["深さ"]),
        Quantity::Altitude => (&["bodenabstand", "höheübergrund", "対地高度"], &["高度"]),
        Quantity::Roll => (
            &["rollwinkel", "krängung", "横揺れ角", "ロール角"],
            &["横揺れ", "横傾斜", "ロール"],
        ),
        Quantity::Pitch => (
            &["nickwinkel", "stampfwinkel", "縦揺れ角", "ピッチ角"],
            &["縦揺れ", "ピッチ"],
        ),
        Quantity::YawRate => (
            &[
                "gierrate",
                "giergeschwindigkeit",
                "drehrate",
                "wendegeschwindigkeit",
                "回頭角速度",
                "ヨー角速度",
                "ヨーレート",
            ],
            &["drehgeschwindigkeit", "旋回角速度", "回頭率"],
        ),
        Quantity::North => (&["nord", "nordwert", "hochwert", "北方向", "北"], &[]),
        Quantity::East => (&["ost", "ostwert", "rechtswert", "東方向", "東"], &[]),
        Quantity::Thrust => (&["schub", "推力"], &[]),
    };
    Names { clear, vague }
}
