// Records of a journal, and how each becomes bytes. Little-endian, as all machines are that 3we runs on.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>

#include "core/bytes.hpp"
#include "threewe/record/recorder.hpp"

namespace threewe::record {

static_assert(std::endian::native == std::endian::little);

/// What a record is. The numbers are part of the format.
enum class RecordType : std::uint8_t {
  begin = 1,        ///< Header
  state = 2,        ///< bytes of `World::save_backend`
  tick = 3,         ///< robot, RecordedTick
  sample = 4,       ///< robot, Sample without its image
  color = 5,        ///< robot, sensor, sequence, width, height, whether encoded; the bytes
  depth = 6,        ///< robot, sensor, sequence, width, height; (H, W) [mm], all low bytes before all high ones
  step = 7,         ///< robot, RecordedStep
  instruction = 8,  ///< robot, RecordedInstruction
  end = 9,          ///< Footer
};

/// What is known of an episode as it begins.
struct Header {
  std::size_t episode = 0;
  std::string task;
  Metadata metadata;
  double started = 0.0;               ///< wall clock [s since 1970]
  Time began{};                       ///< robot time
  std::vector<RecordedRobot> robots;  ///< without what they do
  std::optional<World::Origin> origin;
};

/// What is known of it when it has ended.
struct Footer {
  std::optional<bool> success;
  Metadata metadata;
  bool recovered = false;
};

/// Which image a record belongs to.
struct FrameKey {
  std::uint8_t robot = 0;
  std::uint16_t sensor = 0;
  std::uint64_t sequence = 0;
  std::uint32_t width = 0;   ///< [px]
  std::uint32_t height = 0;  ///< [px]
};

/// Throws ContractError unless a text is UTF-8.
void check_text(const std::string& text);

/// Appends whole records to the content of a block. What throws appends nothing.
class RecordWriter {
 public:
  void put(const Header& header);
  void put(const Footer& footer);
  void put_state(std::span<const std::byte> state);
  void put(std::uint8_t robot, const RecordedTick& tick);
  void put(std::uint8_t robot, const Sample& sample);
  void put(std::uint8_t robot, const RecordedStep& step);
  void put(std::uint8_t robot, const RecordedInstruction& instruction);
  void put_color(const FrameKey& key, bool encoded, std::span<const std::byte> bytes);
  /// Metres become whole millimetres: what is farther than 65.535 m or no number is invalid, that is 0.
  void put_depth(const FrameKey& key, std::span<const float> depth);

  std::size_t size() const { return bytes_.size(); }
  std::vector<std::byte> take() { return bytes_.take(); }

 private:
  template <typename Write>
  void append(RecordType type, const Write& write);
  ByteWriter bytes_;
};

/// One record, as long as the content of its block.
struct Record {
  RecordType type = RecordType::begin;
  std::span<const std::byte> payload;
};
/// Splits the content of a block. Throws ContractError where it cannot have been written.
std::vector<Record> parse_records(std::span<const std::byte> content);

// Each throws ContractError where a payload cannot have been written.
Header parse_header(std::span<const std::byte> payload);
Footer parse_footer(std::span<const std::byte> payload);
std::uint8_t parse(std::span<const std::byte> payload, RecordedTick& tick);
std::uint8_t parse(std::span<const std::byte> payload, Sample& sample);
std::uint8_t parse(std::span<const std::byte> payload, RecordedStep& step);
std::uint8_t parse(std::span<const std::byte> payload, RecordedInstruction& instruction);
/// What follows the key is the image; `encoded` is set for colour alone.
std::span<const std::byte> parse_image(std::span<const std::byte> payload, RecordType type, FrameKey& key,
                                       bool& encoded);
/// (H, W) [mm] of the bytes of a depth record.
std::vector<std::uint16_t> parse_depth(std::span<const std::byte> bytes);

}  // namespace threewe::record
