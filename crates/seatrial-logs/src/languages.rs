//! Names of columns in German, French, Spanish, Italian and Japanese.

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

/// The names of a quantity in German, French, Spanish, Italian and Japanese.
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
