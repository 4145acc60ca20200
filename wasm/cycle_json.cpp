#include "wasm/cycle_json.hpp"

#include <array>
#include <cstddef>
#include <string_view>

#include "device/quantity.hpp"
#include "draw/cycle_drawing.hpp"
#include "draw/layout.hpp"
#include "draw/text.hpp"
#include "verbs/explain/drawing.hpp"

namespace biss::wasm {
namespace {

using nlohmann::json;

json checks_json(const draw::CycleDrawing& drawing) {
  json checks = json::array();
  for (const draw::DrawnCheck& check : drawing.checks) {
    checks.push_back({{"channel", check.channel},
                      {"received", check.received},
                      {"expected", check.expected},
                      {"right", check.right()},
                      {"singles", check.singles}});
  }
  return checks;
}

json bits_json(const draw::CycleDrawing& drawing) {
  json bits = json::array();
  for (const draw::DrawnBit& bit : drawing.bits) {
    json one{{"clock", bit.clock}, {"time", exact(bit.time)}, {"name", bit.name}};
    if (bit.sampled_at) one["sampledAt"] = exact(*bit.sampled_at);
    if (bit.level) one["level"] = *bit.level ? 1 : 0;
    if (bit.payload_bit) one["payloadBit"] = *bit.payload_bit;
    if (bit.expected) one["expected"] = *bit.expected ? 1 : 0;
    bits.push_back(std::move(one));
  }
  return bits;
}

// In the order of draw::PartKind.
constexpr std::array<std::string_view, 5> kind_names{"line", "frame", "data", "flag", "crc"};

json tracks_json(const draw::Layout& layout) {
  json tracks = json::object();
  for (const draw::Track& track : layout.tracks) {
    json parts = json::array();
    for (const draw::Part& part : track.parts) {
      json one{{"kind", kind_names[static_cast<std::size_t>(part.kind)]},
               {"text", part.text},
               {"from", exact(part.from)},
               {"to", exact(part.to)},
               {"wrong", part.wrong}};
      if (!part.brief.empty()) one["brief"] = part.brief;
      parts.push_back(std::move(one));
    }
    tracks[track.name] = std::move(parts);
  }
  return tracks;
}

json failures_json(const draw::Layout& layout) {
  json failures = json::array();
  for (const draw::Mark& mark : layout.failures) {
    failures.push_back({{"time", exact(mark.time)}, {"text", mark.text}});
  }
  return failures;
}

// A time as the page writes it.
std::string shown_time(Picoseconds time) {
  std::string text = biss::text_of(time, 3);
  if (text.ends_with(" us")) text.replace(text.size() - 2, 1, "\u00B5");
  return text;
}

}  // namespace

json cycle_json(std::uint64_t number, const decode::CycleEdges& edges,
                const std::optional<FrameFormat>& format, const DeviceTiming& timing,
                const decode::MarginSetup& margin) {
  const decode::Cycle& cycle = edges.cycle;
  draw::CycleDrawing drawing = draw::draw_cycle(edges, format, timing, margin);
  drawing.number = number;
  const draw::Layout layout =
      draw::lay_out(draw::draw_cycle(edges, format, timing, margin, draw::DrawnExtent::cycle),
                    format, shown_time);
  json one{{"number", drawing.number},
           {"time", exact(cycle.time)},
           {"end", exact(drawing.end)},
           {"period", exact(drawing.period())},
           {"status", name_of(cycle.status)},
           {"title", verbs::drawing_title(drawing)},
           {"text", draw::drawing_text(drawing)},
           {"bits", bits_json(drawing)},
           {"checks", checks_json(drawing)},
           {"tracks", tracks_json(layout)},
           {"failures", failures_json(layout)}};
  if (cycle.cdm) one["cdm"] = *cycle.cdm ? 1 : 0;
  if (cycle.release) one["release"] = exact(*cycle.release);
  return one;
}

}  // namespace biss::wasm
