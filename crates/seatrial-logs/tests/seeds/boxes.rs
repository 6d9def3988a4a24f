//! Logs in the containers of ROS 1, Signal K, Excel and MATLAB.

use std::io::{Cursor, Write};

use super::{ROWS, START_S, heading_rad};

/// A row: time in s, heading in degrees, rudder in degrees.
fn row(k: u32) -> [f64; 3] {
    [0.1 * f64::from(k), f64::from(heading_rad(k)).to_degrees(), 5.0 - f64::from(k)]
}

fn counted(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

fn fields(fields: &[(&str, &[u8])]) -> Vec<u8> {
    let field = |(name, value): &(&str, &[u8])| counted(&[name.as_bytes(), b"=", value].concat());
    fields.iter().flat_map(field).collect()
}

fn record(head: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    [counted(&fields(head)), counted(data)].concat()
}

/// An attitude and a rudder, in chunks of this packing.
pub fn rosbag1(packing: &str) -> Vec<u8> {
    const IMU: &str = "Header header\ngeometry_msgs/Quaternion orientation\n=====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n=====\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w";
    let topics =
        [("/imu", "sensor_msgs/Imu", IMU), ("/rudder", "std_msgs/Float64", "float64 data")];
    let mut bag = b"#ROSBAG V2.0\n".to_vec();
    bag.extend(record(&[("op", &[3])], &[b' '; 64]));
    let mut chunk = Vec::new();
    for (number, (topic, type_name, definition)) in (0_u32..).zip(topics) {
        let says = fields(&[
            ("topic", topic.as_bytes()),
            ("type", type_name.as_bytes()),
            ("message_definition", definition.as_bytes()),
        ]);
        let number = number.to_le_bytes();
        chunk
            .extend(record(&[("op", &[7]), ("conn", &number), ("topic", topic.as_bytes())], &says));
    }
    for k in 0..ROWS {
        let [time_s, heading, rudder] = row(k);
        let nanoseconds = (1e9 * time_s).round() as u32;
        let time = [START_S.to_le_bytes(), nanoseconds.to_le_bytes()].concat();
        let yaw = std::f64::consts::FRAC_PI_2 - heading.to_radians();
        let attitude = [0.0, 0.0, (0.5 * yaw).sin(), (0.5 * yaw).cos()];
        let mut imu = [&k.to_le_bytes()[..], &time, &counted(b"imu")].concat();
        imu.extend(attitude.iter().flat_map(|part| part.to_le_bytes()));
        let rudder = rudder.to_radians().to_le_bytes();
        for (number, data) in [(0_u32, &imu[..]), (1, &rudder)] {
            let number = number.to_le_bytes();
            chunk.extend(record(&[("op", &[2]), ("conn", &number), ("time", &time)], data));
        }
        let size = (chunk.len() as u32).to_le_bytes();
        bag.extend(record(
            &[("op", &[5]), ("compression", packing.as_bytes()), ("size", &size)],
            &packed(packing, &chunk),
        ));
        chunk.clear();
    }
    bag
}

fn packed(packing: &str, chunk: &[u8]) -> Vec<u8> {
    match packing {
        "bz2" => {
            let mut packer = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
            packer.write_all(chunk).unwrap();
            packer.finish().unwrap()
        }
        "lz4" => {
            let mut packer = lz4_flex::frame::FrameEncoder::new(Vec::new());
            packer.write_all(chunk).unwrap();
            packer.finish().unwrap()
        }
        _ => chunk.to_vec(),
    }
}

/// A rudder and a heading in deltas.
pub fn signal_k() -> Vec<u8> {
    let delta = |k: u32, path: &str, value: f64| {
        format!(
            "{{\"context\":\"vessels.self\",\"updates\":[{{\"timestamp\":\"2026-06-08T01:51:24.{k}00Z\",\"$source\":\"n2k.15\",\"values\":[{{\"path\":\"{path}\",\"value\":{value}}}]}}]}}\n"
        )
    };
    let rows = (0..ROWS).map(|k| {
        delta(k, "steering.rudderAngle", 0.1)
            + &delta(k, "navigation.headingTrue", heading_rad(k).into())
    });
    rows.collect::<String>().into_bytes()
}

/// Deltas of Signal K in an array.
pub fn signal_k_array() -> Vec<u8> {
    let lines = String::from_utf8(signal_k()).unwrap();
    format!("[{}]", lines.trim_end().replace('\n', ",\n")).into_bytes()
}

/// One value a row without names of columns.
pub fn topics() -> Vec<u8> {
    let rows = (0..ROWS)
        .map(|k| format!("0.{k}5 boat/heading_deg {}\n0.{k}5 boat/rudder_deg -3.25\n", 80 + k));
    rows.collect::<String>().into_bytes()
}

fn sheet() -> String {
    let mut sheet = String::from(
        "<worksheet xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"><sheetData><row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c></row><row r=\"2\">",
    );
    for (column, place) in ["A", "B", "C"].iter().zip(1..) {
        sheet += &format!("<c r=\"{column}2\" t=\"s\"><v>{place}</v></c>");
    }
    sheet += "</row>";
    for k in 0..ROWS {
        let number = k + 3;
        sheet += &format!("<row r=\"{number}\">");
        for (column, value) in ["A", "B", "C"].iter().zip(row(k)) {
            sheet += &format!("<c r=\"{column}{number}\"><v>{value}</v></c>");
        }
        sheet += "</row>";
    }
    sheet += "</sheetData></worksheet>";
    sheet
}

/// A title, names, and rows.
pub fn xlsx() -> Vec<u8> {
    let sheet = sheet();
    let texts = ["Sea trial, \"fast\"", "time (s)", "heading (deg)", "rudder (deg)"];
    let texts: String = texts.map(|text| format!("<si><t>{text}</t></si>")).concat();
    let texts = format!(
        "<sst xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\">{texts}</sst>"
    );
    let kind = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let parts = [
        (
            "[Content_Types].xml",
            "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"/>"
                .to_owned(),
        ),
        (
            "_rels/.rels",
            format!(
                "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"r1\" Type=\"{kind}/officeDocument\" Target=\"xl/workbook.xml\"/></Relationships>"
            ),
        ),
        (
            "xl/workbook.xml",
            format!(
                "<workbook xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\" xmlns:r=\"{kind}\"><sheets><sheet name=\"Trial\" sheetId=\"1\" r:id=\"r1\"/></sheets></workbook>"
            ),
        ),
        (
            "xl/_rels/workbook.xml.rels",
            format!(
                "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"r1\" Type=\"{kind}/worksheet\" Target=\"worksheets/sheet1.xml\"/><Relationship Id=\"r2\" Type=\"{kind}/sharedStrings\" Target=\"sharedStrings.xml\"/></Relationships>"
            ),
        ),
        ("xl/sharedStrings.xml", texts),
        ("xl/worksheets/sheet1.xml", sheet),
    ];
    let mut file = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        let options = zip::write::SimpleFileOptions::default();
        file.start_file(name, options).unwrap();
        file.write_all(text.as_bytes()).unwrap();
    }
    file.finish().unwrap().into_inner()
}

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut element = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    element.extend(data);
    element.resize(element.len().next_multiple_of(8), 0);
    element
}

fn matrix(class: u32, sizes: [u32; 2], name: &str, rest: &[u8]) -> Vec<u8> {
    let parts = [
        element(6, &[class.to_le_bytes(), [0; 4]].concat()),
        element(5, &sizes.map(u32::to_le_bytes).concat()),
        element(1, name.as_bytes()),
        rest.to_vec(),
    ];
    element(14, &parts.concat())
}

/// A structure of three columns, and a text.
pub fn mat(is_packed: bool) -> Vec<u8> {
    let columns = [0, 1, 2].map(|column| {
        let numbers: Vec<u8> = (0..ROWS).flat_map(|k| row(k)[column].to_le_bytes()).collect();
        matrix(6, [ROWS, 1], "", &element(9, &numbers))
    });
    let mut names = Vec::new();
    for name in ["time_s", "heading_deg", "rudder_deg"] {
        names.extend(name.as_bytes());
        names.resize(names.len().next_multiple_of(32), 0);
    }
    // The length of names is a short element.
    let width = [&[5, 0, 4, 0][..], &32_u32.to_le_bytes()].concat();
    let fields = [width, element(1, &names), columns.concat()].concat();
    let trial = matrix(2, [1, 1], "trial", &fields);
    let note = matrix(4, [1, 4], "note", &element(4, &[b's', 0, b'e', 0, b'a', 0, b'!', 0]));
    let mut file = b"MATLAB 5.0 MAT-file, Platform: GLNXA64".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    for matrix in [note, trial] {
        if is_packed {
            let mut packer =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
            packer.write_all(&matrix).unwrap();
            let packed = packer.finish().unwrap();
            file.extend([15_u32.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat());
            file.extend(packed);
        } else {
            file.extend(matrix);
        }
    }
    file
}

/// Keys and values, as InfluxDB exports them.
pub fn key_value() -> Vec<u8> {
    let mut log = String::new();
    for k in 0..ROWS {
        log += &format!(
            "boat,host=pi heading_deg={}.5,rudder_deg=-3.25 1714564800{k}00000000\n",
            80 + k
        );
    }
    log.into_bytes()
}

/// Objects of JSON, one a line.
pub fn objects() -> Vec<u8> {
    let line = |k| {
        let [time_s, heading, rudder] = row(k);
        format!(
            "{{\"time_s\":{time_s:.1},\"imu\":{{\"heading_deg\":{heading:.4}}},\"rudder_deg\":{rudder:.1}}}\n"
        )
    };
    (0..ROWS).map(line).collect::<String>().into_bytes()
}

/// A glider's log as `dbd2asc` writes it.
pub fn glider() -> Vec<u8> {
    let head = "dbd_label: DBD_ASC(dinkum_binary_data_ascii)file\nencoding_ver: 2\nnum_ascii_tags: 14\nmission_name: TRIAL.MI\n\
        m_present_time m_heading m_fin m_depth\ntimestamp rad rad m\n8 4 4 4\n";
    let line = |k| {
        let [time_s, heading, rudder] = row(k);
        let (time_s, heading, rudder) =
            (f64::from(START_S) + time_s, heading.to_radians(), rudder.to_radians());
        format!("{time_s:.3} {heading:.6} {rudder:.6} NaN \n")
    };
    let rows: String = (0..ROWS).map(line).collect();
    (head.to_owned() + &rows).into_bytes()
}
