//! Names of columns in German, French, Spanish, Italian, Portuguese, Dutch, Danish, Norwegian, Swedish, Polish, Turkish, Russian, Chinese,
//! Japanese and Korean.

use crate::Quantity;

/// What a quantity is called in other languages, lower case without separators.
pub(crate) struct Names {
    /// Words that mean the quantity and nothing else.
    pub clear: &'static [&'static str],
    /// Words that mean the quantity or something near it: a command, a course, a speed over ground.
    pub vague: &'static [&'static str],
}

const TIME: Names = Names {
    clear: &[
        "temps",
        "zeit",
        "tiempo",
        "tempo",
        "時刻",
        "時間",
        "経過時間",
        "tijd",
        "tid",
        "czas",
        "zaman",
        "время",
        "时间",
        "時間戳",
        "시간",
    ],
    vague: &[
        "heure",
        "horodatage",
        "secondes",
        "tempsécoulé",
        "zeitstempel",
        "sekunden",
        "uhrzeit",
        "hora",
        "ora",
        "日時",
        "tijdstip",
        "tidspunkt",
        "saat",
        "时刻",
        "시각",
    ],
};

const HEADING: Names = Names {
    clear: &[
        "cap",
        "capvrai",
        "angledelacet",
        "steuerkurs",
        "gierwinkel",
        "rumbo",
        "prua",
        "船首方位",
        "船首方位角",
        "ヨー角",
        "方位角",
        "航向",
        "航向角",
        "艏向",
        "艏向角",
        "선수방위",
        "선수각",
    ],
    vague: &[
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
        "koers",
        "kompaskoers",
        "proa",
        "rumo",
        "pruva",
        "курс",
        "침로",
    ],
};

const RUDDER: Names = Names {
    clear: &[
        "barre",
        "angledebarre",
        "safran",
        "angledesafran",
        "gouvernail",
        "ruder",
        "ruderwinkel",
        "ruderlage",
        "ruderausschlag",
        "timón",
        "timon",
        "ángulodetimón",
        "timone",
        "angolotimone",
        "舵角",
        "実舵角",
        "roer",
        "roerhoek",
        "roerstand",
        "ror",
        "rorvinkel",
        "roder",
        "rodervinkel",
        "leme",
        "ângulodoleme",
        "ster",
        "kątsteru",
        "dümen",
        "dümenaçısı",
        "руль",
        "уголруля",
        "타각",
    ],
    vague: &[
        "consignedebarre",
        "ordredebarre",
        "ruderkommando",
        "rudersollwinkel",
        "指令舵角",
        "命令舵角",
        "舵",
    ],
};

const SPEED: Names = Names {
    clear: &[
        "vitessesurface",
        "vitesseavance",
        "fahrt",
        "fahrtdurchswasser",
        "fdw",
        "längsgeschwindigkeit",
        "船速",
        "対水速度",
    ],
    vague: &[
        "vitesse",
        "vitessefond",
        "geschwindigkeit",
        "velocidad",
        "velocità",
        "fahrtübergrund",
        "füg",
        "速度",
        "対地速度",
        "速力",
        "snelheid",
        "hastighet",
        "velocidade",
        "prędkość",
        "hız",
        "скорость",
        "航速",
        "속력",
    ],
};

const DEPTH: Names = Names {
    clear: &["profondeur", "immersion", "tiefe", "tauchtiefe", "深度"],
    vague: &["深さ"],
};

const ALTITUDE: Names = Names {
    clear: &["bodenabstand", "höheübergrund", "対地高度"],
    vague: &["高度"],
};

const ROLL: Names = Names {
    clear: &[
        "roulis",
        "gîte",
        "rollwinkel",
        "krängung",
        "横揺れ角",
        "ロール角",
    ],
    vague: &["gite", "横揺れ", "横傾斜", "ロール"],
};

const PITCH: Names = Names {
    clear: &[
        "tangage",
        "assiette",
        "nickwinkel",
        "stampfwinkel",
        "縦揺れ角",
        "ピッチ角",
    ],
    vague: &["縦揺れ", "ピッチ"],
};

const YAW_RATE: Names = Names {
    clear: &[
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
        "draaisnelheid",
        "girhastighet",
        "угловаяскорость",
        "艏向角速度",
        "선회각속도",
    ],
    vague: &["drehgeschwindigkeit", "旋回角速度", "回頭率"],
};

const NORTH: Names = Names {
    clear: &["nord", "nordwert", "hochwert", "北方向", "北"],
    vague: &[],
};

const EAST: Names = Names {
    clear: &["ost", "ostwert", "rechtswert", "東方向", "東"],
    vague: &[],
};

const THRUST: Names = Names {
    clear: &["poussée", "schub", "推力"],
    vague: &["poussee"],
};

/// The names of a quantity in other languages.
pub(crate) fn names(quantity: Quantity) -> &'static Names {
    match quantity {
        Quantity::Time => &TIME,
        Quantity::Heading => &HEADING,
        Quantity::Rudder => &RUDDER,
        Quantity::Speed => &SPEED,
        Quantity::Depth => &DEPTH,
        Quantity::Altitude => &ALTITUDE,
        Quantity::Roll => &ROLL,
        Quantity::Pitch => &PITCH,
        Quantity::YawRate => &YAW_RATE,
        Quantity::North => &NORTH,
        Quantity::East => &EAST,
        Quantity::Thrust => &THRUST,
    }
}
