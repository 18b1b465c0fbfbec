// Codec of OpenImageIO; the only source that includes it.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <algorithm>

#include "io/picture/codec/picture_codec.hpp"

namespace simuli {
namespace {

OIIO::TypeDesc type_of(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return OIIO::TypeDesc::UINT8;
    case SampleType::kUint16:
      return OIIO::TypeDesc::UINT16;
    case SampleType::kFloat:
      break;
  }
  return OIIO::TypeDesc::FLOAT;
}

OIIO::ImageSpec spec_of(const PictureSamples& picture) {
  const PictureLayout& layout = picture.layout;
  OIIO::ImageSpec spec(layout.width, layout.height, layout.channels, type_of(picture.type));
  for (std::size_t c = 0; c < layout.channel_names.size(); ++c)
    spec.channelnames[c] = layout.channel_names[c];
  for (const auto& [name, value] : picture.attributes) spec[name] = value;
  return spec;
}

class OpenImageIoInput : public PictureInput {
 public:
  explicit OpenImageIoInput(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {}
  [[nodiscard]] PictureLayout layout() const override {
    const OIIO::ImageSpec& spec = input_->spec();
    return {spec.width, spec.height, spec.depth, spec.nchannels, spec.channelnames};
  }
  [[nodiscard]] PictureFailure read(std::vector<float>& samples) override {
    constexpr int kRows = 256;  // largest block of the supported formats
    const OIIO::ImageSpec& s = input_->spec();
    const int step = s.tile_height > 0 ? s.tile_height : kRows;
    const auto row = static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.nchannels);
    samples.reserve(row * static_cast<std::size_t>(s.height));
    bool complete = true;
    for (int y = 0; complete && y < s.height; y += step) {
      const int from = s.y + y, to = s.y + std::min(y + step, s.height);
      samples.resize(row * static_cast<std::size_t>(to - s.y));
      float* const at = samples.data() + row * static_cast<std::size_t>(y);
      complete =
          s.tile_width > 0
              ? input_->read_tiles(
                    0, 0, s.x, s.x + s.width, from, to, 0, 1, 0, s.nchannels, OIIO::TypeDesc::FLOAT, at)
              : input_->read_scanlines(0, 0, from, to, 0, 0, s.nchannels, OIIO::TypeDesc::FLOAT, at);
    }
    // The library may return part of the samples with a pending message as the only error.
    const bool clean = input_->close() && !input_->has_error();
    if (complete && clean) return std::nullopt;
    return input_->geterror();
  }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
};

class OpenImageIo : public PictureCodec {
 public:
  /// Without threads: a child of fork() would wait for them forever.
  OpenImageIo() {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
  }
  [[nodiscard]] std::unique_ptr<PictureInput> open(const std::string& format,
                                                   const std::filesystem::path& file,
                                                   std::string& failure) const override {
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;
    std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
    if (!input) {
      failure = OIIO::geterror();
      return nullptr;
    }
    OIIO::ImageSpec spec;
    if (!input->open(file.string(), spec, config)) {
      failure = input->geterror();
      return nullptr;
    }
    return std::make_unique<OpenImageIoInput>(std::move(input));
  }

  [[nodiscard]] PictureFailure write(const std::filesystem::path& file,
                                     const PictureSamples& picture) const override {
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(file.string());
    if (!output) return OIIO::geterror();
    return written(*output, file.string(), picture);
  }

  [[nodiscard]] PictureFailure encode(const std::string& name,
                                      const PictureSamples& picture,
                                      std::string& bytes) const override {
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(name);
    if (!output) return OIIO::geterror();
    std::vector<unsigned char> encoded;
    OIIO::Filesystem::IOVecOutput sink(encoded);
    output->set_ioproxy(&sink);
    PictureFailure failure = written(*output, name, picture);
    if (!failure) bytes.assign(encoded.begin(), encoded.end());
    return failure;
  }

 private:
  static PictureFailure written(OIIO::ImageOutput& output,
                                const std::string& name,
                                const PictureSamples& picture) {
    const bool done = output.open(name, spec_of(picture)) &&
                      output.write_image(type_of(picture.type), picture.samples) && output.close();
    if (done) return std::nullopt;
    return output.geterror();
  }
};

}  // namespace
}  // namespace simuli

[[gnu::visibility("default")]] const simuli::PictureCodec* simuli_picture_codec_2() {
  static const simuli::OpenImageIo codec;
  return &codec;
}
