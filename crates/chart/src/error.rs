/// Failure of a chart.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChartError {
    /// The font of the program cannot be read.
    #[error("the font of the program cannot be read: {reason}")]
    Font {
        /// Fault of the font.
        reason: ttf_parser::FaceParsingError,
    },
    /// The pixels cannot be encoded.
    #[error("the pixels cannot be encoded: {reason}")]
    Encoding {
        /// Fault of the encoder.
        reason: png::EncodingError,
    },
}
