#include "tools/render/image.h"

#include <stb/stb_image_write.h>

#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/status_macros.h"

namespace sinew::render {
namespace {

constexpr int kChannels = 3;

void Append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                             static_cast<size_t>(size));
}

}  // namespace

Image::Image(int width, int height)
    : width(width),
      height(height),
      rgb(static_cast<size_t>(width) * height * kChannels, 0) {}

void Paste(const Image& source, int left, int top, Image* target) {
  SINEW_CHECK(left >= 0 && left + source.width <= target->width);
  SINEW_CHECK(top >= 0 && top + source.height <= target->height);
  for (int row = 0; row < source.height; ++row) {
    const auto from =
        source.rgb.begin() + static_cast<ptrdiff_t>(row) * source.width * 3;
    std::copy(
        from, from + static_cast<ptrdiff_t>(source.width) * 3,
        target->rgb.begin() +
            (static_cast<ptrdiff_t>(top + row) * target->width + left) * 3);
  }
}

absl::StatusOr<std::string> EncodePng(const Image& image) {
  if (image.width <= 0 || image.height <= 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("png: expected at least one pixel, found ", image.width,
                     " x ", image.height));
  }
  std::string bytes;
  if (stbi_write_png_to_func(&Append, &bytes, image.width, image.height,
                             kChannels, image.rgb.data(),
                             image.width * kChannels) == 0) {
    return absl::InternalError(absl::StrCat(
        "png: could not encode ", image.width, " x ", image.height, " pixels"));
  }
  return bytes;
}

absl::StatusOr<std::string> EncodeJpeg(const Image& image, int quality) {
  if (image.width <= 0 || image.height <= 0 || quality < 1 || quality > 100) {
    return absl::InvalidArgumentError(absl::StrCat(
        "jpeg: expected at least one pixel and a quality of 1 to 100, found ",
        image.width, " x ", image.height, " and ", quality));
  }
  std::string bytes;
  if (stbi_write_jpg_to_func(&Append, &bytes, image.width, image.height,
                             kChannels, image.rgb.data(), quality) == 0) {
    return absl::InternalError(absl::StrCat("jpeg: could not encode ",
                                            image.width, " x ", image.height,
                                            " pixels"));
  }
  return bytes;
}

absl::StatusOr<std::string> JpegDataUri(const Image& image, int quality) {
  SINEW_ASSIGN_OR_RETURN(const std::string jpeg, EncodeJpeg(image, quality));
  return absl::StrCat("data:image/jpeg;base64,", absl::Base64Escape(jpeg));
}

}  // namespace sinew::render
