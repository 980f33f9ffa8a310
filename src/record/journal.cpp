// Journals are read whole but for their images, which stay in the file until they are asked for.
#include <algorithm>
#include <exception>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "record/folder.hpp"
#include "record/journal_file.hpp"
#include "record/records.hpp"
#include "record/scan.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::record {
namespace {

// Where an image's record is.
struct ImagePlace {
  std::uint64_t block = 0;  // [bytes] of its header in the file
  std::size_t record = 0;   // number within the block
};

// An image by what it belongs to.
using ImageKey = std::tuple<std::uint8_t, std::uint16_t, std::uint64_t>;
struct StoredImage {
  std::size_t place = 0;
  FrameKey key;
  bool encoded = false;
};

bool ends(std::span<const std::byte> content) {
  const auto records = parse_records(content);
  return !records.empty() && records.back().type == RecordType::end;
}

// The header, from a journal's first block.
Header first_header(std::span<const std::byte> content) {
  const auto records = parse_records(content);
  if (records.empty() || records.front().type != RecordType::begin) {
    throw ContractError("it does not begin as a journal");
  }
  return parse_header(records.front().payload);
}

[[noreturn]] void refuse(const std::filesystem::path& file, std::uint64_t at, const ContractError& why) {
  throw ConfigError(fmt::format("{}: at byte {}: no 3we journal: {}", file.string(), at, why.what()));
}

}  // namespace

struct Journal::Impl {
  explicit Impl(const std::filesystem::path& path) : file(path), reader(path) {}

  std::filesystem::path file;
  Header header;
  Footer footer;
  bool ended = false;
  std::vector<std::byte> state;
  std::vector<ImagePlace> places;
  std::map<ImageKey, StoredImage> colors, depths;
  mutable BlockReader reader;

  void read();
  void add(const BlockPlace& block, std::span<const std::byte> content);
  void add(const Record& record, const ImagePlace& place);
  RecordedRobot& robot(std::uint8_t index);
  void join_images();
  void cut(RecordedRobot& robot, Time end) const;
  std::vector<std::byte> image(std::size_t place, RecordType type) const;
};

void Journal::Impl::read() {
  bool first = true;
  std::uint64_t at = 0;
  try {
    const std::uint64_t end = scan_blocks(file, [&](const BlockPlace& block, std::span<const std::byte> content) {
      at = block.offset;
      if (ended) return false;
      if (std::exchange(first, false)) header = first_header(content);
      const auto records = parse_records(content);
      for (std::size_t i = at == 0 ? 1 : 0; i < records.size(); ++i) add(records[i], {block.offset, i});
      return true;
    });
    at = end;
    if (first) throw ContractError("it does not begin as a journal");
    if (!ended) throw ContractError("a block is torn; was it copied in full?");
    if (end != std::filesystem::file_size(file)) throw ContractError("something follows its end");
    join_images();
  } catch (const ContractError& error) {
    refuse(file, at, error);
  }
}

void Journal::Impl::add(const Record& record, const ImagePlace& place) {
  switch (record.type) {
    case RecordType::begin: throw ContractError("it begins twice");
    case RecordType::state: state.assign(record.payload.begin(), record.payload.end()); return;
    case RecordType::end:
      footer = parse_footer(record.payload);
      ended = true;
      return;
    case RecordType::tick: {
      RecordedTick tick;
      robot(parse(record.payload, tick)).ticks.push_back(tick);
      return;
    }
    case RecordType::sample: {
      Sample sample;
      RecordedRobot& of = robot(parse(record.payload, sample));
      if (sample.sensor >= of.sensors.size() || of.sensors[sample.sensor].type != SensorType(sample.data.index())) {
        throw ContractError("a sample is of no sensor of its robot");
      }
      of.samples.push_back(std::move(sample));
      return;
    }
    case RecordType::step: {
      RecordedStep step;
      robot(parse(record.payload, step)).steps.push_back(std::move(step));
      return;
    }
    case RecordType::instruction: {
      RecordedInstruction instruction;
      robot(parse(record.payload, instruction)).instructions.push_back(std::move(instruction));
      return;
    }
    case RecordType::color:
    case RecordType::depth: {
      StoredImage image{places.size(), {}, false};
      (void)parse_image(record.payload, record.type, image.key, image.encoded);
      (void)robot(image.key.robot);
      auto& images = record.type == RecordType::color ? colors : depths;
      images[{image.key.robot, image.key.sensor, image.key.sequence}] = image;
      places.push_back(place);
      return;
    }
  }
  throw ContractError("a record is of no known type");
}

RecordedRobot& Journal::Impl::robot(std::uint8_t index) {
  if (index >= header.robots.size()) throw ContractError("a record is of no recorded robot");
  return header.robots[index];
}

// Gives each camera sample its image. Where a crash has cut off the last of them, the episode ends before.
void Journal::Impl::join_images() {
  Time cut_at = Time::max();
  for (std::size_t i = 0; i < header.robots.size(); ++i) {
    RecordedRobot& of = header.robots[i];
    for (const Sample& sample : of.samples) {
      if (of.sensors[sample.sensor].type != SensorType::camera) continue;
      const ImageKey key{static_cast<std::uint8_t>(i), sample.sensor, sample.sequence};
      const auto color = colors.find(key);
      if (color == colors.end()) {
        if (!footer.recovered) throw ContractError("an image is missing");
        cut_at = std::min(cut_at, sample.received);
        continue;
      }
      const auto& [place, stored, encoded] = color->second;
      RecordedFrame frame{sample.sensor, sample.sequence, sample.measured, sample.received};
      frame.width = static_cast<int>(stored.width);
      frame.height = static_cast<int>(stored.height);
      frame.encoded = encoded;
      frame.color = place;
      if (const auto depth = depths.find(key); depth != depths.end()) frame.depth = depth->second.place;
      of.frames.push_back(frame);
    }
  }
  for (RecordedRobot& robot : header.robots) cut(robot, cut_at);
}

void Journal::Impl::cut(RecordedRobot& robot, Time end) const {
  std::erase_if(robot.ticks, [end](const RecordedTick& tick) { return tick.now >= end; });
  std::erase_if(robot.samples, [end](const Sample& sample) { return sample.received >= end; });
  std::erase_if(robot.frames, [end](const RecordedFrame& frame) { return frame.received >= end; });
  std::erase_if(robot.steps, [end](const RecordedStep& step) { return step.now >= end; });
  std::erase_if(robot.instructions, [end](const RecordedInstruction& it) { return it.now >= end; });
}

std::vector<std::byte> Journal::Impl::image(std::size_t place, RecordType type) const {
  const ImagePlace& at = places.at(place);
  if (!reader.read(at.block)) throw ConfigError(file.string() + ": has changed since it was opened");
  const Record record = parse_records(reader.content()).at(at.record);
  FrameKey key;
  bool encoded = false;
  const auto bytes = parse_image(record.payload, type, key, encoded);
  return {bytes.begin(), bytes.end()};
}

Journal::Journal() = default;
Journal::Journal(Journal&&) noexcept = default;
Journal& Journal::operator=(Journal&&) noexcept = default;
Journal::~Journal() = default;

Journal Journal::open(const std::filesystem::path& file) {
  Journal journal;
  journal.impl_ = std::make_unique<Impl>(file);
  journal.impl_->read();
  return journal;
}

std::size_t Journal::episode() const { return impl_->header.episode; }
const std::string& Journal::task() const { return impl_->header.task; }
std::optional<bool> Journal::success() const { return impl_->footer.success; }
Metadata Journal::metadata() const {
  Metadata all = impl_->footer.metadata;
  all.insert(impl_->header.metadata.begin(), impl_->header.metadata.end());
  return all;
}
bool Journal::recovered() const { return impl_->footer.recovered; }
double Journal::started() const { return impl_->header.started; }
Time Journal::began() const { return impl_->header.began; }
const std::vector<RecordedRobot>& Journal::robots() const { return impl_->header.robots; }
const std::optional<World::Origin>& Journal::origin() const { return impl_->header.origin; }
std::span<const std::byte> Journal::initial_state() const { return impl_->state; }

std::vector<std::byte> Journal::color(const RecordedFrame& frame) const {
  return impl_->image(frame.color, RecordType::color);
}

std::vector<std::uint16_t> Journal::depth(const RecordedFrame& frame) const {
  if (!frame.depth) throw ContractError("this frame has no depth");
  return parse_depth(impl_->image(*frame.depth, RecordType::depth));
}

JournalHeader read_header(const std::filesystem::path& journal) {
  BlockReader reader(journal);
  try {
    if (!reader.read(0)) throw ContractError("it does not begin as a journal");
    const Header header = first_header(reader.content());
    JournalHeader read{header.episode, header.task, {}};
    for (const RecordedRobot& robot : header.robots) read.robots.push_back(robot.profile);
    return read;
  } catch (const ContractError& error) {
    refuse(journal, 0, error);
  }
}

std::vector<std::filesystem::path> journals(const std::filesystem::path& folder) {
  return episodes_in(folder, kFinished);
}

namespace {

// Truncates an unfinished journal behind its last sound block, and finishes it as the recorder would have.
Recovered recover_one(FileSystem& files, const std::filesystem::path& part) {
  bool begun = false;
  bool ended = false;
  const std::uint64_t sound = scan_blocks(part, [&](const BlockPlace& block, std::span<const std::byte> content) {
    if (ended) return false;
    try {
      if (!std::exchange(begun, true)) (void)first_header(content);
      ended = ends(content);
    } catch (const ContractError& error) {  // no crash has done that: it stays as it is
      refuse(part, block.offset, error);
    }
    return true;
  });
  Recovered it;
  it.lost_bytes = std::filesystem::file_size(part) - sound;
  std::filesystem::path stem = part;
  stem.replace_extension();
  JournalFile file(files, stem, sound);
  if (!begun) {
    file.discard();
    return it;
  }
  RecordWriter footer;
  footer.put(Footer{.success = {}, .metadata = {}, .recovered = true});
  if (!ended) file.append(footer.take());
  file.finish();
  it.file = stem += kFinished;
  it.ticks = Journal::open(it.file).robots().front().ticks.size();
  return it;
}

}  // namespace

std::vector<Recovered> recover(const std::filesystem::path& folder, const std::shared_ptr<FileSystem>& files) {
  if (!std::filesystem::is_directory(folder)) throw RecordingError(folder.string() + ": no such folder");
  const auto system = files ? files : std::make_shared<FileSystem>();
  const FolderLock lock(*system, folder);
  std::vector<Recovered> all;
  std::exception_ptr refused;  // the first, once all others are finished
  for (const std::filesystem::path& part : episodes_in(folder, kUnfinished)) {
    try {
      all.push_back(recover_one(*system, part));
    } catch (const ConfigError&) {
      if (!refused) refused = std::current_exception();
    }
  }
  if (refused) std::rethrow_exception(refused);
  return all;
}

}  // namespace threewe::record
