//! Names of columns in English, and in German, French, Spanish, Italian, Portuguese, Dutch, Danish, Norwegian, Swedish, Polish, Turkish,
//! Russian, Chinese, Japanese and Korean: lower case without separators, with blanks between them.

use crate::Quantity;
use crate::words::is_among;

/// What a quantity is called.
pub(crate) struct Names {
    /// In English, in groups from the clearest to the vaguest.
    english: &'static [&'static str],
    /// Words of other languages that mean the quantity and nothing else.
    clear: &'static str,
    /// Words that mean the quantity or something near it: a command, a course, a speed over ground.
    vague: &'static str,
}

impl Names {
    /// The group of a name, 0 for the clearest: those in English, then clear and vague ones of other languages.
    pub fn group_of(&self, name: &str) -> Option<usize> {
        let mut groups = self.english.iter().copied().chain(self.others());
        groups.position(|names| is_among(names, name))
    }

    /// Every name in English.
    pub fn in_english(&self) -> Vec<&'static str> {
        let groups = self.english.iter();
        groups.flat_map(|names| names.split_ascii_whitespace()).collect()
    }

    /// The groups of other languages.
    pub fn others(&self) -> [&'static str; 2] {
        [self.clear, self.vague]
    }
}

const TIME: Names = Names {
    english: &[
        "time t",
        "timestamp ts stamp elapsed elapsedtime seconds secs sec millis datenum micros ticks tick itow tow filetime \
            julianday juliandate jd mjd secondsofday xvalue hhmmss hhmmsssss",
        "epoch unixtime utc datetime date clock lastchanged lastupdated ms",
    ],
    clear: "temps zeit tiempo tempo 時刻 時間 経過時間 tijd tid czas zaman время 时间 時間戳 시간",
    vague: "heure horodatage secondes tempsécoulé zeitstempel sekunden uhrzeit hora ora 日時 tijdstip tidspunkt \
        saat 时刻 시각",
};

const HEADING: Names = Names {
    english: &[
        "heading yaw psi psihat hdg hdt trueheading headingtrue",
        "headingangle yawangle compass compassheading hdm magneticheading headingmagnetic",
    ],
    clear: "cap capvrai angledelacet steuerkurs gierwinkel rumbo prua 船首方位 船首方位角 ヨー角 方位角 航向 航向角 \
        艏向 艏向角 선수방위 선수각",
    vague: "capcompas capmagnétique lacet kompasskurs kompass kurs kurswinkel 方位 針路 回頭角 ヨー koers \
        kompaskoers proa rumo pruva курс 침로",
};

const RUDDER: Names = Names {
    english: &[
        "rudder rudderangle delta deltar deltarudder rud rsa",
        "rudderposition rudderpos rudderfeedback rudderdeflection rudderactual actualrudder ruddermeasured \
            measuredrudder fin finangle tailfin steering steer steeringangle helm helmangle tiller tillerangle",
        "ruddercmd ruddercommand commandedrudder rudderorder deltacmd deltac fincmd steeringcmd steercmd",
        "servo pwm",
    ],
    clear: "barre angledebarre safran angledesafran gouvernail ruder ruderwinkel ruderlage ruderausschlag timón \
        timon ángulodetimón timone angolotimone 舵角 実舵角 roer roerhoek roerstand ror rorvinkel roder rodervinkel \
        leme ângulodoleme ster kątsteru dümen dümenaçısı руль уголруля 타각",
    vague: "consignedebarre ordredebarre ruderkommando rudersollwinkel 指令舵角 命令舵角 舵",
};

const SPEED: Names = Names {
    english: &[
        "surgespeed surge u uvelo uvel forwardspeed surgevelocity",
        "speed speedthroughwater stw waterspeed boatspeed bsp spd velocity vel",
        "speedoverground sog groundspeed",
    ],
    clear: "vitessesurface vitesseavance fahrt fahrtdurchswasser fdw längsgeschwindigkeit 船速 対水速度",
    vague: "vitesse vitessefond geschwindigkeit velocidad velocità fahrtübergrund füg 速度 対地速度 速力 snelheid \
        hastighet velocidade prędkość hız скорость 航速 속력",
};

const DEPTH: Names = Names {
    english: &["depth", "z"],
    clear: "profondeur immersion tiefe tauchtiefe 深度",
    vague: "深さ",
};

const ALTITUDE: Names = Names {
    english: &["altitude", "alt heightabovebottom"],
    clear: "bodenabstand höheübergrund 対地高度",
    vague: "高度",
};

const ROLL: Names = Names {
    english: &["roll phi", "heel bank"],
    clear: "roulis gîte rollwinkel krängung 横揺れ角 ロール角",
    vague: "gite 横揺れ 横傾斜 ロール",
};

const PITCH: Names = Names {
    english: &["pitch theta"],
    clear: "tangage assiette nickwinkel stampfwinkel 縦揺れ角 ピッチ角",
    vague: "縦揺れ ピッチ",
};

const YAW_RATE: Names = Names {
    english: &[
        "yawrate r psidot headingrate rateofturn rot turnrate yawspeed yawvelocity rangvelo yawangularvelocity",
        "gyroz omegaz wz gyrz gz",
    ],
    clear: "vitessedelacet vitessedegiration tauxdegiration gierrate giergeschwindigkeit drehrate \
        wendegeschwindigkeit 回頭角速度 ヨー角速度 ヨーレート draaisnelheid girhastighet угловаяскорость 艏向角速度 \
        선회각속도",
    vague: "drehgeschwindigkeit 旋回角速度 回頭率",
};

const NORTH: Names = Names {
    english: &["north northing posnorth", "x posx"],
    clear: "nord nordwert hochwert 北方向 北",
    vague: "",
};

const EAST: Names = Names {
    english: &["east easting poseast", "y posy"],
    clear: "ost ostwert rechtswert 東方向 東",
    vague: "",
};

const THRUST: Names =
    Names { english: &["thrust", "throttle"], clear: "poussée schub 推力", vague: "poussee" };

/// The names of a quantity.
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
