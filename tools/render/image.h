#ifndef SINEW_TOOLS_RENDER_IMAGE_H_
#define SINEW_TOOLS_RENDER_IMAGE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace sinew::render {

// A picture: rows from the top, pixels from the left, three bytes each (red,
// green, blue; sRGB).
struct Image {
  Image() = default;
  Image(int width, int height);  // black

  int width = 0;
  int height = 0;
  std::vector<uint8_t> rgb;  // [height, width, 3]
};

// Copies `source` into `target` with its top left corner at (left, top).
// Precondition: it fits.
void Paste(const Image& source, int left, int top, Image* target);

// The picture as the bytes of a PNG file. INVALID_ARGUMENT: no pixels.
absl::StatusOr<std::string> EncodePng(const Image& image);

// As a JPEG file, `quality` in [1, 100]: smaller, with losses.
// INVALID_ARGUMENT: no pixels, or quality out of range.
absl::StatusOr<std::string> EncodeJpeg(const Image& image, int quality);

// The same as a data URI, for a page that loads nothing. Errors: EncodeJpeg's.
absl::StatusOr<std::string> JpegDataUri(const Image& image, int quality);

}  // namespace sinew::render

#endif  // SINEW_TOOLS_RENDER_IMAGE_H_
