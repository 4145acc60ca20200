// What is known about a capture before its cause is looked for: how it reads, and what it carries.
#pragma once

#include "cli/common/decoded_capture.hpp"
#include "explain/diagnose.hpp"

namespace biss::cli {

/// How the lines of a capture read best. \pre as DecodedCapture::beginning()
explain::Reading choose_reading(DecodedCapture& capture, const CaptureArguments& arguments);

/// An observer of the capture, as it is read from its beginning.
class CaptureObserver final : public ChangeWatcher {
 public:
  /// \pre as DecodedCapture::beginning()
  CaptureObserver(DecodedCapture& capture, const decode::Lines& lines);

  void take(std::span<const wire::Edge> edges) override;
  void take(const capture::PairPiece& changes) override;

  /// Reads the capture to its end. \param on_cycle sees each cycle too; or null
  /// \return as DecodedCapture::read()
  bool read(const std::function<void(const decode::Cycle&)>& on_cycle = nullptr);
  const explain::Evidence& evidence() const { return *evidence_; }

 private:
  DecodedCapture& capture_;
  explain::Observer observer_;
  const explain::Evidence* evidence_ = nullptr;
};

/// What diagnose() needs beside the cycles. \pre as DecodedCapture::beginning()
explain::Context explain_context(DecodedCapture& capture, const CaptureArguments& arguments,
                                 const MarginArguments& margin);

}  // namespace biss::cli
