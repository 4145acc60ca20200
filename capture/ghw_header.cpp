#include "capture/ghw_header.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

#include "capture/leb128.hpp"

namespace biss::capture {

bool GhwStream::fill() {
  if (failed_) return false;
  const auto got = block_.read(*bytes_);
  if (!got.ok()) cause_ = CaptureCause::read_failed;
  failed_ = !got.ok() || got->empty();
  if (!failed_) rest_ = *got;
  return !failed_;
}

// One of more than 64 bits is no number of anything either.
std::uint32_t GhwStream::unsigned_number() {
  const auto value = unsigned_leb128([this] { return byte(); });
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(value.value_or(UINT32_MAX), UINT32_MAX));
}

std::int64_t GhwStream::signed_number() {
  const auto value = signed_leb128([this] { return byte(); });
  return value.value_or(std::numeric_limits<std::int64_t>::min());
}

std::uint32_t GhwStream::word() {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) {
    const std::uint32_t next = byte();
    value |= next << (big_endian_ ? 24 - 8 * i : 8 * i);
  }
  return value;
}

std::int64_t GhwStream::time() {
  const std::uint64_t first = word();
  const std::uint64_t second = word();
  return static_cast<std::int64_t>(big_endian_ ? first << 32U | second : second << 32U | first);
}

std::array<char, 4> GhwStream::name() {
  std::array<char, 4> letters{};
  for (char& letter : letters) letter = static_cast<char>(byte());
  return letters;
}

namespace {

using wire::Level;

// Kinds of types, as in GHDL's grt-rtis and libghw.
enum TypeKind : std::uint8_t {
  enum_2 = 22,
  enum_256 = 23,
  integer_32 = 25,
  integer_64 = 26,
  real_64 = 27,
  physical_32 = 28,
  physical_64 = 29,
  array = 31,
  record = 32,
  scalar_subtype = 34,
  array_subtype = 35,
  unbounded_array = 37,
  record_subtype = 38,
  unbounded_record = 39,
};

// Kinds of entries of the hierarchy.
enum EntryKind : std::uint8_t {
  end_of_hierarchy = 0,
  design = 1,
  scope_block = 3,
  if_generate = 4,
  for_generate = 5,
  instance = 6,
  package = 7,
  process = 13,
  generic = 14,
  end_of_scope = 15,
  first_signal = 16,
  last_signal = 21,
};

constexpr std::uint64_t most_signals = 1U << 22U;
constexpr std::uint64_t most_text_bytes = 64U << 20U;
constexpr std::uint64_t most_type_bytes = 64U << 20U;
constexpr std::uint64_t most_elements_of_lines = 64;
constexpr unsigned most_type_depth = 64;

struct Range {
  std::int64_t left = 0;
  bool down = false;
  std::uint64_t length = 0;
};

struct Field {
  std::uint32_t name = 0;
  std::uint32_t type = 0;
};

struct Type {
  TypeKind kind{};                    // of a subtype of scalars: that of its base
  bool unbounded = false;             // it needs bounds before it can have signals
  unsigned depth = 0;                 // of types in one another
  std::uint64_t scalars = 1;          // that it consists of
  std::uint32_t element = 0;          // of arrays
  std::uint32_t open_element = 0;     // of arrays: the element before it got bounds
  std::uint32_t dimensions = 0;       // of arrays
  std::vector<Range> ranges;          // of bounded arrays
  std::vector<Field> fields;          // of records: those that have scalars, or may have
  std::vector<std::uint32_t> values;  // of enumerations: their names
  std::uint32_t letters = no_letters;

  static constexpr std::uint32_t no_letters = UINT32_MAX;
};

// The level of each value of an enumeration; empty if it is no signal of one bit.
std::vector<Level> levels_of(std::span<const std::string> values) {
  std::vector<Level> meanings;
  bool has_low = false;
  bool has_high = false;
  for (const std::string& value : values) {
    const bool low = value == "'0'" || value == "false";
    const bool high = value == "'1'" || value == "true";
    has_low = has_low || low;
    has_high = has_high || high;
    meanings.push_back(low || value == "'L'"    ? Level::low
                       : high || value == "'H'" ? Level::high
                                                : Level::unknown);
  }
  if (!has_low || !has_high) meanings.clear();
  return meanings;
}

// The numbers of an element of an array: `(3)`, `(0,1)`.
std::string index_text(std::span<const Range> ranges, std::uint64_t element) {
  std::vector<std::int64_t> indexes;
  for (auto range = ranges.rbegin(); range != ranges.rend(); ++range) {
    const auto step = static_cast<std::int64_t>(element % range->length);
    element /= range->length;
    indexes.push_back(range->down ? range->left - step : range->left + step);
  }
  std::string text = "(";
  for (auto index = indexes.rbegin(); index != indexes.rend(); ++index) {
    if (text.size() > 1) text += ',';
    text += std::to_string(*index);
  }
  return text + ')';
}

class HeaderReader {
 public:
  explicit HeaderReader(GhwStream& stream) : stream_(stream) {}

  tl::expected<GhwHeader, CaptureError> read() {
    if (read_start() && read_sections() && take_signals()) return std::move(header_);
    // Beyond the end every number is 0, which may look wrong first.
    if (stream_.failed()) error_ = {.cause = stream_.cause(), .part = part_};
    return tl::unexpected(error_);
  }

 private:
  bool fail(CaptureCause cause, const char* expected = nullptr) {
    error_ = {.cause = cause, .expected = expected, .part = part_};
    return false;
  }
  bool malformed(const char* expected) { return fail(CaptureCause::malformed, expected); }
  bool good() const { return !stream_.failed(); }

  bool read_start();
  bool read_sections();
  bool read_strings();
  bool read_types();
  bool read_known_types();
  bool read_hierarchy();
  bool read_entry(std::uint8_t kind);
  bool read_scope(std::uint8_t kind);
  bool read_signal(std::uint32_t type, const std::string& name, bool as_lines);
  bool read_scalar(const Type& type, const std::string& name, bool as_lines);
  bool take_signals();

  bool read_string_id(std::uint32_t& id);
  bool read_type_id(std::uint32_t& id);
  bool read_type(Type& type);
  bool read_enumeration(Type& type);
  bool read_units();
  bool read_array(Type& type);
  bool read_record(Type& type);
  bool read_range(Range& range);
  bool bound(std::uint32_t base, Type& type, unsigned nesting);
  bool bound_array(std::uint32_t base, Type& type, unsigned nesting);
  bool bound_record(std::uint32_t base, Type& type, unsigned nesting);
  bool bound_part(std::uint32_t& part, unsigned nesting);
  bool add_scalars(Type& type, std::uint64_t scalars, std::uint64_t times);
  bool add_type(Type type);
  static GhwValue value_of(const Type& type);

  GhwStream& stream_;
  const char* part_ = "the header";
  CaptureError error_;
  std::uint8_t version_ = 0;
  std::vector<std::string> strings_;
  std::vector<Type> types_;  // bounded ones that have no number too
  std::vector<std::uint32_t> numbered_;
  std::uint64_t type_bytes_ = 0;
  std::uint64_t signal_count_ = 0;
  std::unordered_map<std::uint32_t, std::uint32_t> variables_;
  GhwHeader header_;
};

bool HeaderReader::read_start() {
  constexpr std::string_view magic("GHDLwave\n\x10\0", 11);
  for (const char letter : magic) {
    if (static_cast<char>(stream_.byte()) != letter) return malformed("a GHW of version 0 or 1");
  }
  version_ = stream_.byte();
  const std::uint8_t order = stream_.byte();
  stream_.skip(3);  // bytes of a word and of a place in the file; 0
  if (version_ > 1) return malformed("a GHW of version 0 or 1");
  if (order != 1 && order != 2) return malformed("a byte order of 1 or 2");
  stream_.set_big_endian(order == 2);
  return good();
}

bool HeaderReader::read_sections() {
  for (;;) {
    part_ = "the header";
    const std::array<char, 4> name = stream_.name();
    const std::string_view section(name.data(), name.size());
    if (!good()) return false;
    using namespace std::string_view_literals;
    if (section == "EOH\0"sv) return true;
    if (stream_.word() != 0) return malformed("four zeros after the name of a section");
    bool read = false;
    if (section == "STR\0"sv) {
      read = read_strings();
    } else if (section == "TYP\0"sv) {
      read = read_types();
    } else if (section == "WKT\0"sv) {
      read = read_known_types();
    } else if (section == "HIE\0"sv) {
      read = read_hierarchy();
    } else {
      return malformed("the section STR, TYP, WKT, HIE or EOH");
    }
    if (!read) return false;
  }
}

// A string shares its first letters with the one before. Letters are Latin-1; what ends a string
// says how many the next one shares.
bool HeaderReader::read_strings() {
  part_ = "the strings";
  const std::uint32_t count = stream_.word();
  stream_.word();  // letters
  std::uint64_t text_bytes = 0;
  std::string raw;
  std::size_t shared = 0;
  strings_.assign(1, "_");
  for (std::uint32_t i = 0; i < count && good(); ++i) {
    if (shared > raw.size()) return malformed("no more shared letters than there are");
    raw.resize(shared);
    std::uint8_t letter = stream_.byte();
    for (; (letter & 0x60U) != 0; letter = stream_.byte()) raw += static_cast<char>(letter);
    text_bytes += raw.size() + sizeof(std::string);
    if (text_bytes > most_text_bytes) return fail(CaptureCause::too_many_lines);
    std::string text;
    for (const char c : raw) {
      const auto code = static_cast<unsigned char>(c);
      if (code >= 0x80) text += static_cast<char>(0xC0U | code >> 6U);
      text += code >= 0x80 ? static_cast<char>(0x80U | (code & 0x3FU)) : c;
    }
    strings_.push_back(std::move(text));
    shared = letter & 0x1FU;
    for (unsigned shift = 5; letter >= 0x80; shift += 5) {
      letter = stream_.byte();
      if (shift > 25) return malformed("fewer shared letters");
      shared |= std::size_t{letter & 0x1FU} << shift;
    }
  }
  const std::array<char, 4> end = stream_.name();
  if (good() && std::string_view(end.data(), 3) != "EOS") return malformed("EOS after the strings");
  return good();
}

bool HeaderReader::read_string_id(std::uint32_t& id) {
  id = stream_.unsigned_number();
  if (!good()) return false;
  return id < strings_.size() || malformed("the number of a string");
}

// To a place in types_. Only types before the one that is read have a number.
bool HeaderReader::read_type_id(std::uint32_t& id) {
  const std::uint32_t number = stream_.unsigned_number();
  if (!good()) return false;
  if (number == 0 || number > numbered_.size()) return malformed("the number of an earlier type");
  id = numbered_[number - 1];
  return true;
}

bool HeaderReader::read_types() {
  part_ = "the types";
  const std::uint32_t count = stream_.word();
  for (std::uint32_t i = 0; i < count; ++i) {
    Type type;
    if (!read_type(type) || !good() || !add_type(std::move(type))) return false;
    numbered_.push_back(static_cast<std::uint32_t>(types_.size() - 1));
  }
  if (stream_.byte() != 0) return malformed("0 after the types");
  return good();
}

bool HeaderReader::add_type(Type type) {
  // A subtype takes few bytes in the file, whatever its base has.
  type_bytes_ += sizeof(Type) + type.ranges.size() * sizeof(Range) +
                 type.fields.size() * sizeof(Field) + type.values.size() * sizeof(std::uint32_t);
  if (type_bytes_ > most_type_bytes) return fail(CaptureCause::too_many_lines);
  if (type.depth > most_type_depth) return malformed("at most 64 types in one another");
  types_.push_back(std::move(type));
  return true;
}

bool HeaderReader::read_type(Type& type) {
  const std::uint8_t kind = stream_.byte();
  std::uint32_t name = 0;
  if (!read_string_id(name)) return false;
  type.kind = static_cast<TypeKind>(kind);
  std::uint32_t base = 0;
  Range range;
  switch (kind) {
    case enum_2:
    case enum_256:
      return read_enumeration(type);
    case integer_32:
    case integer_64:
    case real_64:
      return true;
    case physical_32:
    case physical_64:
      return read_units();
    case scalar_subtype:
      if (!read_type_id(base) || !read_range(range)) return false;
      type = types_[base];
      return true;
    case array:
      return read_array(type);
    case record:
      return read_record(type);
    case array_subtype:
    case record_subtype:
      return read_type_id(base) && bound(base, type, 0);
    case unbounded_array:
    case unbounded_record:
      if (!read_type_id(base)) return false;
      type = types_[base];
      return true;
    default:
      return malformed("a type that GHDL 0.2 to 5 has");
  }
}

bool HeaderReader::read_enumeration(Type& type) {
  const std::uint32_t count = stream_.unsigned_number();
  std::vector<std::string> values;
  constexpr std::uint32_t most_of_levels = 16;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t value = 0;
    if (!read_string_id(value)) return false;
    if (count <= most_of_levels) values.push_back(strings_[value]);
    type.values.push_back(value);
    if (type.values.size() > 256) return malformed("at most 256 values of an enumeration");
  }
  std::vector<Level> meanings = levels_of(values);
  if (meanings.empty()) return true;
  type.letters = static_cast<std::uint32_t>(header_.letters.size());
  header_.letters.push_back(std::move(meanings));
  return true;
}

bool HeaderReader::read_units() {
  if (version_ == 0) return true;
  const std::uint32_t units = stream_.unsigned_number();
  for (std::uint32_t i = 0; i < units; ++i) {
    std::uint32_t name = 0;
    if (!read_string_id(name)) return false;
    stream_.signed_number();
  }
  return true;
}

bool HeaderReader::read_array(Type& type) {
  if (!read_type_id(type.element)) return false;
  type.dimensions = stream_.unsigned_number();
  if (type.dimensions == 0) return malformed("an array with a dimension");
  for (std::uint32_t i = 0; i < type.dimensions; ++i) {
    std::uint32_t index = 0;
    if (!read_type_id(index)) return false;
  }
  type.open_element = type.element;
  type.unbounded = true;
  type.depth = types_[type.element].depth + 1;
  return true;
}

bool HeaderReader::read_record(Type& type) {
  const std::uint32_t fields = stream_.unsigned_number();
  type.scalars = 0;
  for (std::uint32_t i = 0; i < fields; ++i) {
    Field field;
    if (!read_string_id(field.name) || !read_type_id(field.type)) return false;
    const Type& part = types_[field.type];
    type.unbounded = type.unbounded || part.unbounded;
    type.depth = std::max(type.depth, part.depth + 1);
    if (!part.unbounded && !add_scalars(type, part.scalars, 1)) return false;
    if (part.unbounded || part.scalars != 0) type.fields.push_back(field);
  }
  return true;
}

bool HeaderReader::add_scalars(Type& type, std::uint64_t scalars, std::uint64_t times) {
  if (times != 0 && scalars > most_signals / times) return malformed("a type of fewer elements");
  type.scalars += scalars * times;
  return type.scalars <= most_signals || malformed("a type of fewer elements");
}

bool HeaderReader::read_range(Range& range) {
  const std::uint8_t head = stream_.byte();
  range.down = (head & 0x80U) != 0;
  std::int64_t right = 0;
  switch (head & 0x7FU) {
    case enum_2:
    case enum_256:
      range.left = stream_.byte();
      right = stream_.byte();
      break;
    case integer_32:
    case physical_32:
    case integer_64:
    case physical_64:
      range.left = stream_.signed_number();
      right = stream_.signed_number();
      break;
    case real_64:
      stream_.skip(16);
      break;
    default:
      return malformed("a range of a scalar type");
  }
  const std::int64_t low = range.down ? right : range.left;
  const std::int64_t high = range.down ? range.left : right;
  range.length =
      low > high ? 0 : static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low) + 1;
  return good();
}

// Reads the bounds that make a type of an unbounded array or record.
bool HeaderReader::bound(std::uint32_t base, Type& type, unsigned nesting) {
  if (nesting > most_type_depth) return malformed("at most 64 types in one another");
  const TypeKind kind = types_[base].kind;
  if (kind == array || kind == array_subtype) return bound_array(base, type, nesting);
  if (kind == record || kind == record_subtype) return bound_record(base, type, nesting);
  return malformed("the bounds of an array or a record");
}

// A part that is unbounded gets bounds, and becomes a type without a number.
bool HeaderReader::bound_part(std::uint32_t& part, unsigned nesting) {
  if (!types_[part].unbounded) return true;
  Type bounded;
  if (!bound(part, bounded, nesting + 1) || !add_type(std::move(bounded))) return false;
  part = static_cast<std::uint32_t>(types_.size() - 1);
  return true;
}

bool HeaderReader::bound_array(std::uint32_t base, Type& type, unsigned nesting) {
  type = {};
  type.kind = array_subtype;
  type.element = types_[base].open_element;
  type.open_element = type.element;
  type.dimensions = types_[base].dimensions;
  type.depth = types_[base].depth;
  type.scalars = 0;
  std::uint64_t elements = 1;
  for (std::uint32_t i = 0; i < type.dimensions; ++i) {
    Range range;
    if (!read_range(range)) return false;
    if (range.length != 0 && elements > most_signals / range.length) {
      return malformed("a type of fewer elements");
    }
    elements *= range.length;
    type.ranges.push_back(range);
  }
  return bound_part(type.element, nesting) &&
         add_scalars(type, types_[type.element].scalars, elements);
}

bool HeaderReader::bound_record(std::uint32_t base, Type& type, unsigned nesting) {
  type = types_[base];
  type.kind = record_subtype;
  if (!type.unbounded) return true;
  type.unbounded = false;
  type.scalars = 0;
  for (Field& field : type.fields) {
    if (!bound_part(field.type, nesting)) return false;
    if (!add_scalars(type, types_[field.type].scalars, 1)) return false;
  }
  std::erase_if(type.fields, [&](const Field& field) { return types_[field.type].scalars == 0; });
  return true;
}

// Which types are std_ulogic is seen from their values.
bool HeaderReader::read_known_types() {
  part_ = "the known types";
  while (stream_.byte() != 0) {
    std::uint32_t type = 0;
    if (!read_type_id(type)) return false;
  }
  return good();
}

bool HeaderReader::read_hierarchy() {
  part_ = "the hierarchy";
  stream_.word();  // scopes
  stream_.word();  // declared signals
  signal_count_ = stream_.word();
  for (;;) {
    const std::uint8_t kind = stream_.byte();
    if (!good()) return false;
    if (kind == end_of_hierarchy) return true;
    if (!read_entry(kind)) return false;
  }
}

bool HeaderReader::read_entry(std::uint8_t kind) {
  if (kind == end_of_scope) {
    if (header_.lines.depth() == 0) return malformed("a scope for each that is closed");
    header_.lines.close_scope();
    return true;
  }
  if (kind < first_signal || kind > last_signal) return read_scope(kind);
  std::uint32_t name = 0;
  std::uint32_t type = 0;
  if (!read_string_id(name) || !read_type_id(type)) return false;
  if (types_[type].unbounded) return malformed("a signal of a type with bounds");
  return read_signal(type, strings_[name], types_[type].scalars <= most_elements_of_lines);
}

bool HeaderReader::read_scope(std::uint8_t kind) {
  std::uint32_t id = 0;
  if (!read_string_id(id)) return false;
  std::string name = strings_[id];
  switch (kind) {
    case process:
      return true;  // nothing is in it, and nothing closes it
    case for_generate: {
      std::uint32_t type = 0;
      if (!read_type_id(type)) return false;
      if (value_of(types_[type]) == GhwValue::real) return malformed("a number of a generate");
      std::string value;
      if (value_of(types_[type]) == GhwValue::letter) {
        const std::uint8_t letter = stream_.byte();
        const std::vector<std::uint32_t>& values = types_[type].values;
        value = letter < values.size() ? strings_[values[letter]] : std::to_string(letter);
      } else {
        value = std::to_string(stream_.signed_number());
      }
      name += '(' + value + ')';
      break;
    }
    case design:
    case scope_block:
    case if_generate:
    case instance:
    case package:
    case generic:
      break;
    default:
      return malformed("a scope or a signal");
  }
  if (header_.lines.depth() == DeclaredLines::max_depth) {
    return malformed("at most 256 scopes in one another");
  }
  return header_.lines.open_scope(name) || fail(CaptureCause::too_many_lines);
}

bool HeaderReader::read_signal(std::uint32_t id, const std::string& name, bool as_lines) {
  const Type& type = types_[id];
  if (type.scalars == 0) return true;
  if (type.kind == array_subtype) {
    const std::uint64_t elements = type.scalars / types_[type.element].scalars;
    for (std::uint64_t i = 0; i < elements; ++i) {
      const std::string element = as_lines ? name + index_text(type.ranges, i) : std::string();
      if (!read_signal(type.element, element, as_lines)) return false;
    }
    return true;
  }
  if (type.kind == record || type.kind == record_subtype) {
    return std::all_of(type.fields.begin(), type.fields.end(), [&](const Field& field) {
      const std::string part = as_lines ? name + '.' + strings_[field.name] : std::string();
      return read_signal(field.type, part, as_lines);
    });
  }
  return read_scalar(type, name, as_lines);
}

bool HeaderReader::read_scalar(const Type& type, const std::string& name, bool as_lines) {
  GhwSignal signal{.number = stream_.unsigned_number(), .value = value_of(type)};
  if (!good()) return false;
  if (signal.number == 0 || signal.number > signal_count_) {
    return malformed("the number of a signal");
  }
  if (header_.signals.size() == most_signals) return fail(CaptureCause::too_many_lines);
  if (as_lines && type.letters != Type::no_letters) {
    const auto entry = variables_.try_emplace(signal.number, header_.variables).first;
    if (entry->second == header_.variables) ++header_.variables;
    signal.variable = entry->second;
    signal.type = type.letters;
    if (!header_.lines.add(name, signal.variable)) return fail(CaptureCause::too_many_lines);
  }
  header_.signals.push_back(signal);
  return true;
}

GhwValue HeaderReader::value_of(const Type& type) {
  if (type.kind == enum_2 || type.kind == enum_256) return GhwValue::letter;
  return type.kind == real_64 ? GhwValue::real : GhwValue::number;
}

// Values come in the order of the numbers of signals. A signal may be declared several times; the
// first declaration says how its values are stored, any of them may make it a line.
bool HeaderReader::take_signals() {
  std::vector<GhwSignal>& signals = header_.signals;
  std::stable_sort(signals.begin(), signals.end(),
                   [](const GhwSignal& a, const GhwSignal& b) { return a.number < b.number; });
  std::size_t kept = 0;
  for (const GhwSignal& signal : signals) {
    if (kept == 0 || signals[kept - 1].number != signal.number) {
      signals[kept++] = signal;
      continue;
    }
    GhwSignal& first = signals[kept - 1];
    if (first.variable == GhwSignal::no_variable && first.value == GhwValue::letter) {
      std::tie(first.variable, first.type) = std::tie(signal.variable, signal.type);
    }
  }
  signals.resize(kept);
  if (!header_.lines.finish()) return fail(CaptureCause::too_many_lines);
  return true;
}

}  // namespace

tl::expected<GhwHeader, CaptureError> read_ghw_header(GhwStream& stream) {
  return HeaderReader(stream).read();
}

}  // namespace biss::capture
