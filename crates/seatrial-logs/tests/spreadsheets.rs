//! Logs as spreadsheets and loggers of other countries write them: title rows, decimal commas, dates with the day first,
//! times of day, remarks in the brackets of a name, thousands in groups, degree signs, Japanese, French and German names.

use seatrial_core::Sample;
use seatrial_logs::{ChannelChoice, open};

const ROWS: usize = 100;

fn read(text: &str) -> Vec<Sample<f64>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, text).unwrap();
    let reader = open(&path, &ChannelChoice::default())
        .unwrap_or_else(|why| panic!("{why}\n{}", &text[..80]));
    reader.collect::<Result<_, _>>().unwrap_or_else(|why| panic!("{why}\n{}", &text[..80]))
}

/// A log with a head, and rows of time, heading in degrees, rudder in degrees and speed in knots.
fn log(head: &str, row: impl Fn(f64, f64, f64, f64) -> String) -> String {
    let rows = (0..ROWS).map(|k| {
        let time_s = 0.1 * k as f64;
        row(time_s, 80.5 + 0.25 * k as f64, [12.5, -12.5][k / 10 % 2], 4.0)
    });
    std::iter::once(head.to_owned()).chain(rows).collect::<Vec<_>>().join("\r\n") + "\r\n"
}

fn point(time_s: f64, heading: f64, rudder: f64, speed: f64) -> String {
    format!("{time_s:.1},{heading:.2},{rudder:.1},{speed:.2}")
}

fn comma(time_s: f64, heading: f64, rudder: f64, speed: f64) -> String {
    format!("{time_s:.1};{heading:.2};{rudder:.1};{speed:.2}").replace('.', ",")
}

/// 12:00:00.0 and so on.
fn clock(time_s: f64) -> String {
    format!("12:00:{time_s:04.1}")
}

/// A digit or point of full width.
fn wide(letter: char) -> char {
    char::from_u32(letter as u32 + 0xfee0).unwrap()
}

/// Angles in minutes, halves of a day, and dates in Japanese.
fn of_other_clocks() -> [String; 6] {
    [
        log("Time [s],Heading,Rudder,Speed [kn]", |t, h, r, v| {
            let minutes = |angle: f64| {
                let sign = if angle < 0.0 { "-" } else { "" };
                let angle = angle.abs();
                format!("{sign}{}°{:.1}'", angle.trunc(), 60.0 * angle.fract())
            };
            format!("{t:.1},{},{},{v:.2}", minutes(h), minutes(r))
        }),
        log("Time,Heading [deg],Rudder [deg],Speed [kn]", |t, h, r, v| {
            format!("5/23/2026 12:00:{t:04.1} PM,{h:.2},{r:.1},{v:.2}")
        }),
        log("Time,Heading [deg],Rudder [deg],Speed [kn]", |t, h, r, v| {
            format!("00:{t:04.1},{h:.2},{r:.1},{v:.2}")
        }),
        log("日時,船首方位[度],舵角[度],船速[ノット]", |t, h, r, v| {
            format!("2026年5月3日 12:00:{t:04.1},{h:.2},{r:.1},{v:.2}")
        }),
        log("日時,船首方位[度],舵角[度],船速[ノット]", |t, h, r, v| {
            let wide = format!("{h:.2}").chars().map(wide).collect::<String>();
            format!("2026年05月03日 12時00分{t:04.1}秒,{wide},{r:.1},{v:.2}")
        }),
        log("Time [s],Heading [deg],Rudder [deg],Speed [kn]", |t, h, r, v| {
            let side = if r < 0.0 { "P" } else { "S" };
            format!("{t:.1},{h:.2} T,{:.1} {side},{v:.2}", r.abs())
        }),
    ]
}

#[test]
fn io_every_spelling_gives_the_same_samples() {
    let of_day = |time_s: f64, heading: f64, rudder: f64, speed: f64| {
        format!("03.05.2026;{};{heading:.2};{rudder:.1};{speed:.2}", clock(time_s))
            .replacen('.', "-", 2)
            .replace('.', ",")
            .replacen('-', ".", 2)
    };
    let stamped = |time_s: f64, heading: f64, rudder: f64, speed: f64| {
        format!("03/05/2026 {};{heading:.2};{rudder:.1};{speed:.2}", clock(time_s))
    };
    let logs = [
        log("Time [s],Heading [deg],Rudder [deg],Speed [kn]", point),
        log("Zeit [s];Kurs [°];Ruder [°];Fahrt [kn]", comma),
        log("Zeit;Kurs (rw);Ruderlage (Grad);FdW (Knoten)", comma),
        log("Datum;Uhrzeit;Kurs;Ruderwinkel;Fahrt [kn]", of_day),
        log("Timestamp;HDG;RUD;STW [kn]", stamped),
        log("時刻[s],船首方位[度],舵角[度],船速[ノット]", point),
        log("Time (s),Heading (°T),Rudder (° stbd +),Speed over ground (knots)", point),
        log(
            "\u{feff}Messfahrt 12;;;\r\nBoot: Möwe;;;\r\n;;;\r\nZeit;Kurs;Ruder;Fahrt\r\ns;Grad;Grad;kn",
            comma,
        ),
        log(
            "Sea trial No. 3,,,\r\n\"Recorded by A. Smith, 3 May 2026\",,,\r\n,,,\r\nElapsed time,Compass heading,Helm,SOG\r\n(s),(deg),(deg),(kt)",
            point,
        ),
        log("Temps [s];Cap [°];Barre [°];Vitesse [kn]", comma),
        log("Time [s]|Heading [deg]|Rudder [deg]|Speed [kn]", |t, h, r, v| {
            point(t, h, r, v).replace(',', "|")
        }),
        log("Zeit [s];Kurs;Ruder;Fahrt [kn]", |t, h, r, v| {
            format!("{t:.1};{h:.2}°;{r:.1} °;{v:.2}").replace('.', ",")
        }),
        log("Zeit [ms];Kurs [°];Ruder [°];Fahrt [kn]", |t, h, r, v| {
            let thousandths = (1000.0 * t).round() as u64;
            let rest = comma(t, h, r, v);
            let rest = rest.split_once(';').unwrap().1;
            format!("1.{:03}.{:03},0;{rest}", 200 + thousandths / 1000, thousandths % 1000)
        }),
        log("Time (min),Heading (deg),Rudder (deg),Speed (kn)", |t, h, r, v| {
            format!("{:.14},{h:.2},{r:.1},{v:.2}", t / 60.0)
        }),
        log("Date,Heading (deg),Rudder (deg),Speed (kn)", |t, h, r, v| {
            format!("{:.13},{h:.2},{r:.1},{v:.2}", 45_424.5 + t / 86_400.0)
        }),
        log(
            "Time [s],Heading [deg],Rudder command [deg],Rudder actual [deg],Speed [kn]",
            |t, h, r, v| format!("{t:.1},{h:.2},{:.1},{r:.1},{v:.2}", 0.5 * r),
        ),
    ];
    let logs = [logs.as_slice(), &of_other_clocks()].concat();
    let expected = read(&logs[0]);
    assert_eq!(expected.len(), ROWS);
    for text in &logs[1..] {
        let samples = read(text);
        assert_eq!(samples.len(), ROWS, "{text:.60}");
        for (sample, expected) in samples.iter().zip(&expected) {
            let passed_s = sample.time_s - samples[0].time_s;
            // A time of day has five digits before the point.
            let rounding_s = match text.starts_with("Date") {
                true => 1e-6,
                false => 1e-9,
            };
            assert!((passed_s - expected.time_s).abs() < rounding_s, "{text:.60}");
            assert_eq!(sample.heading_rad, expected.heading_rad, "{text:.60}");
            assert_eq!(sample.rudder_rad, expected.rudder_rad, "{text:.60}");
            assert_eq!(sample.surge_speed_m_s, expected.surge_speed_m_s, "{text:.60}");
        }
    }
}

/// What is wrong with a log.
fn fault(bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, bytes).unwrap();
    let read = open(&path, &ChannelChoice::default())
        .and_then(|reader| reader.collect::<Result<Vec<_>, _>>());
    read.expect_err("a fault").to_string()
}

#[test]
fn io_a_column_that_is_no_numbers_is_not_left_out() {
    let text = log("Time [s],Heading [deg],Rudder [deg],Speed [kn]", |t, h, r, v| {
        format!("{t:.1},{h:.0}d{h:.0}m,{r:.1},{v:.2}")
    });
    let said = fault(text.as_bytes());
    assert!(said.contains("100 of 100 rows are like this"), "{said}");
    assert!(!said.contains("--drop-invalid"), "{said}");
}

#[test]
fn io_utf_16_without_its_mark_is_named() {
    let text = log("Time [s],Heading [deg],Rudder [deg],Speed [kn]", point);
    let bytes: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let said = fault(&bytes);
    assert!(said.contains("the text is in UTF-16"), "{said}");
}

/// -9999 and the words of spreadsheets for nothing leave their rows out.
#[test]
fn io_words_for_nothing_are_no_values() {
    let nothing = ["-9999", "n/a", "-", "#N/A", ""];
    let text = log("Time [s],Heading [deg],Rudder [deg],Speed [kn]", |t, h, r, v| {
        match (10.0 * t).round() as usize {
            k @ 10..15 => format!("{t:.1},{},{r:.1},{v:.2}", nothing[k - 10]),
            _ => point(t, h, r, v),
        }
    });
    assert_eq!(read(&text).len(), ROWS - 5);
}
