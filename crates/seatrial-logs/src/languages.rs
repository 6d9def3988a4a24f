//! Names of columns in German, French and Japanese.

use crate::Quantity;

/// What a quantity is called in other languages, lower case without separators.
pub(crate) struct Names {
    /// Words that mean the quantity and nothing else.
    pub clear: &'static [&'static str],
    /// Words that mean the quantity or something near it: a command, a course, a speed over ground.
    pub vague: &'static [&'static str],
}

/// The names of a quantity in German, French and Japanese.
pub(crate) fn names(quantity: Quantity) -> Names {
    let (clear, vague): (&[&str], &[&str]) = match quantity {
        Quantity::Time => (
            &["temps", "zeit", "時刻", "時間", "経過時間"],
            &[
                "heure",
                "horodatage",
                "secondes",
                "tempsécoulé",
                "zeitstempel",
                "sekunden",
                "uhrzeit",
                "日時",
            ],
        ),
        Quantity::Heading => (
            &[
                "cap",
                "capvrai",
                "angledelacet",
                "steuerkurs",
                "gierwinkel",
                "船首方位",
                "船首方位角",
                "ヨー角",
                "方位角",
            ],
            &[
                "capcompas",
                "capmagnétique",
                "lacet",
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
                "barre",
                "angledebarre",
                "safran",
                "angledesafran",
                "gouvernail",
                "ruder",
                "ruderwinkel",
                "ruderlage",
                "ruderausschlag",
                "舵角",
                "実舵角",
            ],
            &[
                "consignedebarre",
                "ordredebarre",
                "ruderkommando",
                "rudersollwinkel",
                "指令舵角",
                "命令舵角",
                "舵",
            ],
        ),
        Quantity::Speed => (
            &[
                "vitessesurface",
                "vitesseavance",
                "fahrt",
                "fahrtdurchswasser",
                "fdw",
                "längsgeschwindigkeit",
                "船速",
                "対水速度",
            ],
            &[
                "vitesse",
                "vitessefond",
                "geschwindigkeit",
                "fahrtübergrund",
                "füg",
                "速度",
                "対地速度",
                "速力",
            ],
        ),
        Quantity::Depth => (
            &["profondeur", "immersion", "tiefe", "tauchtiefe", "深度"],
            &["深さ"],
        ),
        Quantity::Altitude => (&["bodenabstand", "höheübergrund", "対地高度"], &["高度"]),
        Quantity::Roll => (
            &[
                "roulis",
                "gîte",
                "rollwinkel",
                "krängung",
                "横揺れ角",
                "ロール角",
            ],
            &["gite", "横揺れ", "横傾斜", "ロール"],
        ),
        Quantity::Pitch => (
            &[
                "tangage",
                "assiette",
                "nickwinkel",
                "stampfwinkel",
                "縦揺れ角",
                "ピッチ角",
            ],
            &["縦揺れ", "ピッチ"],
        ),
        Quantity::YawRate => (
            &[
                "vitessedelacet",
                "vitessedegiration",
                "tauxdegiration",
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
        Quantity::Thrust => (&["poussée", "schub", "推力"], &["poussee"]),
    };
    Names { clear, vague }
}
