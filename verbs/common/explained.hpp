// The facts about a capture that the search for a cause needs: its readings and its protocol.
#pragma once

#include "explain/diagnose.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// How the lines of a capture read best. \pre as DecodedCapture::beginning()
explain::Reading choose_reading(DecodedCapture& capture, const CaptureArguments& arguments);

/// An observer of the capture, which is read from its beginning; it also watches the capture's
/// changes.
class CaptureObserver final : public flow::ChangeWatcher {
 public:
  /// \pre as DecodedCapture::beginning()
  CaptureObserver(DecodedCapture& capture, const decode::Lines& lines);

  void take(std::span<const wire::Edge> edges) override;
  void take(const capture::PairPiece& changes) override;

  /// The next cycle.
  void add(std::uint64_t number, const decode::Cycle& cycle) { observer_.add(number, cycle); }
  /// After the last cycle. \return valid as long as this object
  const explain::Evidence& finish(Picoseconds end_time) { return observer_.finish(end_time); }

 private:
  explain::Observer observer_;
};

/// The facts that diagnose() needs in addition to the cycles. \pre as DecodedCapture::beginning()
explain::Context explain_context(DecodedCapture& capture, const CaptureArguments& arguments,
                                 const MarginArguments& margin);

}  // namespace biss::verbs
