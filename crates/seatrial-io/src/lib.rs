//! Vehicle logs in and out: formats, channels, units, time.
