#include "server/live/live_drawing.h"

#include "server/api/frame_json.h"

#include <utility>

namespace clerestory {

std::shared_ptr<LiveDrawing> LiveDrawing::of(LiveView& view, const LiveSettings& settings) {
    return view.drawing(
        settings, [&] { return std::shared_ptr<LiveDrawing>(new LiveDrawing(view, settings)); });
}

// Keeps what was measured while only the view and settings of equal cost change.
void LiveDrawing::setPace(const FrameRequest& frame) {
    if (settings_.targetMs == 0.0) return;
    Ladder ladder = ladderOf(frame);
    if (pace_ && pace_->ladder() == ladder) return;
    pace_.emplace(std::move(ladder), settings_.targetMs);
}

// With the lock of drawing_ held.
LiveDrawing::Picture LiveDrawing::drawnAt(std::size_t level, const FrameRequest& frame,
                                          std::uint64_t version, bool isRefinement,
                                          const Draw& draw) {
    const Level settings = pace_ ? pace_->ladder().levels[level] : Level{};
    const FrameRequest scaled = atLevel(frame, settings);
    const auto cancellation = view_.cancellationOf(version);
    if (cancellation->cancelled()) return nullptr;
    Drawn drawn;
    try {
        drawn = draw({scaled, cancellation, isRefinement});
    } catch (const RequestError&) {
        if (!cancellation->cancelled()) throw;
        return nullptr;
    }
    if (pace_) pace_->measured(level, drawn.milliseconds);
    last_ = std::make_shared<const LivePicture>(
        LivePicture{.bytes = std::make_shared<const std::string>(std::move(drawn.bytes)),
                    .version = version,
                    .serial = serial_ + 1,
                    .level = level,
                    .settings = settings,
                    .width = scaled.width,
                    .height = scaled.height,
                    .milliseconds = drawn.milliseconds,
                    .lightShare = drawn.lightShare});
    lastText_ = canonicalText(frame);
    ++serial_;
    return last_;
}

LiveDrawing::Picture LiveDrawing::moved(const Picture& seen, std::optional<double> time,
                                        const Draw& draw) {
    const std::uint64_t before = serial_;
    const std::lock_guard lock(drawing_);
    // Another stream has drawn while this one waited.
    const bool isNew = serial_ != before && (!seen || last_->version > seen->version ||
                                             (time && last_->serial > seen->serial));
    if (isNew) return last_;
    for (;;) {
        const LiveView::Shown shown = view_.shown();
        FrameRequest frame = shown.request;
        if (time) frame.time = *time;
        if (last_ && last_->lightShare >= 1.0 && canonicalText(frame) == lastText_) {
            if (last_->version == shown.version) return last_;
            LivePicture same = *last_;
            same.version = shown.version;
            same.serial = serial_ + 1;
            same.milliseconds = 0.0;
            last_ = std::make_shared<const LivePicture>(std::move(same));
            ++serial_;
            return last_;
        }
        setPace(frame);
        const std::size_t level = pace_ ? pace_->moving() : 0;
        if (const Picture drawn = drawnAt(level, frame, shown.version, false, draw)) return drawn;
    }
}

LiveDrawing::Picture LiveDrawing::refined(const Picture& seen, const Draw& draw) {
    const std::lock_guard lock(drawing_);
    const LiveView::Shown shown = view_.shown();
    if (shown.version != seen->version || !pace_) return nullptr;
    const bool isShared = last_->version == seen->version && last_->level < seen->level;
    if (isShared) return last_;
    return drawnAt(pace_->refined(seen->level), shown.request, shown.version, true, draw);
}

LiveDrawing::Picture LiveDrawing::relit(const Picture& seen, const Draw& draw) {
    const std::lock_guard lock(drawing_);
    const LiveView::Shown shown = view_.shown();
    if (shown.version != seen->version) return nullptr;
    const bool isShared = last_->version == seen->version && last_->serial > seen->serial;
    if (isShared) return last_;
    return drawnAt(seen->level, shown.request, shown.version, true, draw);
}

}  // namespace clerestory
