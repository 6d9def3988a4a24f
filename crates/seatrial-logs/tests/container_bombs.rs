//! Small files in containers that unpack to much, or whose lengths say so.
#![cfg(all(feature = "containers", feature = "parquet", feature = "mcap"))]

use std::io::{Cursor, Write};

use crate::bombs::{MOST_MEMORY_KB, lz4_zeros, read};
use crate::memory::peak_memory_kb;

const MEGABYTE: usize = 1 << 20;

/// A workbook whose sheet is 256 MB of blanks.
fn workbook() -> Vec<u8> {
    let kind = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let parts = [
        ("[Content_Types].xml", "<Types/>".to_owned()),
        (
            "xl/workbook.xml",
            format!(
                "<workbook xmlns:r=\"{kind}\"><sheets><sheet name=\"a\" sheetId=\"1\" r:id=\"r1\"/></sheets></workbook>"
            ),
        ),
        (
            "xl/_rels/workbook.xml.rels",
            format!(
                "<Relationships><Relationship Id=\"r1\" Type=\"{kind}/worksheet\" Target=\"worksheets/sheet1.xml\"/></Relationships>"
            ),
        ),
    ];
    let mut file = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for (name, text) in parts {
        file.start_file(name, options).unwrap();
        file.write_all(text.as_bytes()).unwrap();
    }
    file.start_file("xl/worksheets/sheet1.xml", options).unwrap();
    file.write_all(b"<worksheet><sheetData>").unwrap();
    for _ in 0..256 {
        file.write_all(&vec![b' '; MEGABYTE]).unwrap();
    }
    file.finish().unwrap().into_inner()
}

/// A bag of ROS 1 of one chunk.
fn bag(packing: &str, chunk: &[u8], length: u32) -> Vec<u8> {
    let counted = |bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), bytes].concat();
    let head = [
        counted(b"op=\x05"),
        counted(format!("compression={packing}").as_bytes()),
        counted(&[&b"size="[..], &u32::MAX.to_le_bytes()].concat()),
    ];
    let head = counted(&head.concat());
    [b"#ROSBAG V2.0\n", &head[..], &length.to_le_bytes(), chunk].concat()
}

/// 256 MB of zeros in bzip2: 64 times a stream of 4 MB.
fn bzip2_zeros() -> Vec<u8> {
    let mut packer = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    packer.write_all(&vec![0; 4 * MEGABYTE]).unwrap();
    packer.finish().unwrap().repeat(64)
}

/// A MATLAB file of one packed element: of 256 MB of zeros behind a matrix that says it has 4 GB.
fn matlab() -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    let matrix = [14, u32::MAX - 7, 6, 8, 6, 0, 5, 8, 1 << 30, 1, 1, 8, 0, 0, 9, u32::MAX - 7];
    packer.write_all(&matrix.map(u32::to_le_bytes).concat()).unwrap();
    for _ in 0..256 {
        packer.write_all(&vec![0; MEGABYTE]).unwrap();
    }
    let packed = packer.finish().unwrap();
    let mut file = b"MATLAB 5.0 MAT-file, Platform: GLNXA64".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    file.extend([15_u32.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat());
    file.extend(packed);
    file
}

/// A heading of NMEA 2000 as a recorder of Yacht Devices writes it.
fn heading() -> Vec<u8> {
    [&[0, 0][..], &0x09f1_120f_u32.to_le_bytes(), &[0, 1, 2, 0xff, 0x7f, 0xff, 0x7f, 0xfd]].concat()
}

/// One test, because memory is that of the process.
#[test]
fn io_containers_of_bombs_and_absurd_lengths_cost_neither_time_nor_memory() {
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    let folder = tempfile::tempdir().unwrap();
    let fast_packet = [&[0, 0][..], &0x0df8_050f_u32.to_le_bytes(), &[0, 255]].concat();
    let yacht_devices = [heading().repeat(8), fast_packet.repeat(1000)].concat();
    let wide = |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    let without_end = [vec![0xff, 0xfe], wide("time_s,"), b"a\0".repeat(8 * MEGABYTE)].concat();
    let names = wide("time_s,heading_deg,rudder_deg\n0,1,2\n0.1,1,2\n");
    let row_without_end = [vec![0xff, 0xfe], names, b"1\0".repeat(8 * MEGABYTE)].concat();
    let bombs = [
        ("a workbook of 256 MB", workbook(), "unpacks to more than any log holds"),
        ("bzip2 of 256 MB", bag("bz2", &bzip2_zeros(), bzip2_zeros().len() as u32), ""),
        ("lz4 of 256 MB", bag("lz4", &lz4_zeros(), lz4_zeros().len() as u32), ""),
        ("a chunk of 4 GB that is not there", bag("none", &[0; 100], u32::MAX), ""),
        ("a matrix of 4 GB", matlab(), ""),
        ("packets of 255 bytes", yacht_devices, ""),
        ("a message without end", [&[0x1b, 1, 7][..], &vec![0x55; 2 * MEGABYTE]].concat(), ""),
        ("a gateway without end", [&[0x10, 2][..], &vec![0x93; 2 * MEGABYTE]].concat(), ""),
        ("names without end", without_end, ""),
        ("a row without end", row_without_end, ""),
    ];
    let before_kb = peak_memory_kb();
    for (name, bomb, expected) in &bombs {
        let (samples, fault) = read(folder.path(), bomb);
        let text = fault.map(|fault| fault.to_string());
        println!("{name}: {samples} samples, {text:?}");
        assert!(samples <= 2, "{name}: {samples}");
        assert!(text.is_some_and(|text| text.contains(expected)), "{name}");
    }
    if let (Some(before_kb), Some(after_kb)) = (before_kb, peak_memory_kb()) {
        let grown_kb = after_kb - before_kb;
        println!("{grown_kb} kB more than before");
        let longest = bombs.iter().map(|(_, bomb, _)| bomb.len()).max();
        let twice_kb = 2 * longest.unwrap() as u64 / 1024;
        assert!(grown_kb < MOST_MEMORY_KB + twice_kb, "{grown_kb} kB");
    }
}
