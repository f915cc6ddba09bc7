// Which request a live view draws next, with a function instead of a renderer: requests that are
// put while it draws are events within its calls.
#include "server/live/live_drawing.h"

#include "server/base/problem.h"

#include <gtest/gtest.h>

#include <future>
#include <thread>
#include <vector>

namespace clerestory::test {
namespace {

using Picture = LiveDrawing::Picture;

FrameRequest pose(double exposure) {
    FrameRequest request;
    request.exposure = exposure;
    return request;
}

// A view whose frames take 400 ms for all pixels of a request, on paper.
struct Studio {
    explicit Studio(double targetMs) : drawing(LiveDrawing::of(view, {.targetMs = targetMs})) {
        put(0);
    }

    void put(double exposure) { view.put(pose(exposure), ""); }
    LiveDrawing::Draw draw() {
        return [this](const LiveDrawing::Order& order) {
            const FrameRequest& frame = order.request;
            drawn.push_back(frame);
            orders.push_back(order);
            if (during) std::exchange(during, nullptr)();
            const bool ends = order.isRefinement || stillWaits;
            if (ends && order.cancellation->cancelled()) throw RequestError(clientLeft());
            if (isFull) throw RequestError(queueFull(1));
            const double pixels = 1.0 * frame.width * frame.height / (1280 * 720);
            return LiveDrawing::Drawn{std::to_string(frame.exposure), 400 * pixels, lightShare};
        };
    }
    Picture moved() { return last = drawing->moved(last, std::nullopt, draw()); }
    Picture relit() {
        const Picture lit = drawing->relit(last, draw());
        if (lit) last = lit;
        return lit;
    }
    Picture refined() {
        const Picture finer = drawing->refined(last, draw());
        if (finer) last = finer;
        return finer;
    }

    LiveView view;
    std::shared_ptr<LiveDrawing> drawing;
    Picture last;
    std::vector<FrameRequest> drawn;
    std::vector<LiveDrawing::Order> orders;
    std::function<void()> during;  // called once, while a frame is drawn
    bool stillWaits = false;       // no frame begins before it is cancelled
    bool isFull = false;
    double lightShare = 1.0;
};

TEST(LiveDrawing, OfThePosesDuringAFrameTheNewestIsDrawnNext) {
    for (const double target : {0.0, 100.0}) {
        Studio studio(target);
        studio.during = [&] {
            for (int i = 1; i <= 5; ++i) studio.put(i);
        };
        EXPECT_EQ(studio.moved()->version, 1u) << "the frame that was begun is shown";
        EXPECT_EQ(studio.moved()->version, 6u);
        ASSERT_EQ(studio.drawn.size(), 2u);
        EXPECT_EQ(studio.drawn[1].exposure, 5.0);
        EXPECT_EQ(studio.moved()->version, 6u);
        EXPECT_EQ(studio.drawn.size(), 2u) << "nothing is drawn twice";
        for (const LiveDrawing::Order& order : studio.orders) {
            EXPECT_FALSE(order.isRefinement) << "a frame in motion that has begun is completed";
        }
    }
}

TEST(LiveDrawing, WithoutATargetEveryFrameIsTheRequest) {
    Studio studio(0.0);
    const Picture picture = studio.moved();
    EXPECT_EQ(picture->level, 0u);
    EXPECT_EQ(studio.drawn[0].width, 1280u);
    EXPECT_EQ(studio.refined(), nullptr);
    EXPECT_EQ(studio.drawn.size(), 1u);
}

TEST(LiveDrawing, AViewAtRestIsDrawnAgainWithMoreLight) {
    for (const double target : {0.0, 100.0}) {
        Studio studio(target);
        studio.lightShare = 0.0;
        const Picture first = studio.moved();
        EXPECT_EQ(first->lightShare, 0.0);
        studio.lightShare = 1.0;
        const Picture lit = studio.relit();
        ASSERT_NE(lit, nullptr);
        EXPECT_EQ(lit->lightShare, 1.0);
        EXPECT_EQ(lit->version, first->version);
        EXPECT_EQ(lit->level, first->level);
        EXPECT_GT(lit->serial, first->serial);
        EXPECT_TRUE(studio.orders.back().isRefinement) << "a pose cancels it";
        EXPECT_EQ(studio.drawn.size(), 2u);
        // Another stream that shows the first picture takes this one.
        studio.last = first;
        EXPECT_EQ(studio.relit(), lit);
        EXPECT_EQ(studio.drawn.size(), 2u);
        studio.put(7);
        EXPECT_EQ(studio.relit(), nullptr);
    }
}

TEST(LiveDrawing, MotionIsSmallAndRestIsRefinedToTheRequest) {
    Studio studio(100.0);
    for (int i = 1; i < 8; ++i) {
        studio.put(i);
        studio.moved();
    }
    EXPECT_GT(studio.last->level, 0u);
    EXPECT_LT(studio.last->width, 1280u);
    while (studio.last->level > 0) {
        const std::size_t level = studio.last->level;
        ASSERT_NE(studio.refined(), nullptr);
        EXPECT_LT(studio.last->level, level);
        EXPECT_TRUE(studio.orders.back().isRefinement);
    }
    EXPECT_EQ(studio.last->width, 1280u);
    EXPECT_EQ(studio.last->version, 8u);
}

TEST(LiveDrawing, APoseCancelsTheRefinementAndIsDrawnNext) {
    Studio studio(100.0);
    studio.moved();
    const std::size_t moving = studio.last->level;
    studio.during = [&] {
        EXPECT_FALSE(studio.orders.back().cancellation->cancelled());
        studio.put(7);
        EXPECT_TRUE(studio.orders.back().cancellation->cancelled());
    };
    EXPECT_EQ(studio.refined(), nullptr);
    EXPECT_EQ(studio.moved()->version, 2u);
    EXPECT_EQ(studio.drawn.size(), 3u);
    EXPECT_EQ(studio.drawn.back().exposure, 7.0);
    EXPECT_LE(studio.last->level, moving);
    EXPECT_LT(studio.last->width, 1280u) << "not at full size";
}

TEST(LiveDrawing, ARefinementOfAnOldPoseDoesNotBegin) {
    Studio studio(100.0);
    studio.moved();
    studio.put(1);
    EXPECT_EQ(studio.refined(), nullptr);
    EXPECT_EQ(studio.drawn.size(), 1u);
}

TEST(LiveDrawing, ANewerPoseReplacesTheOneThatWaits) {
    for (const bool isFull : {false, true}) {
        Studio studio(100.0);
        studio.stillWaits = true;
        studio.isFull = isFull;
        studio.during = [&] {
            for (int i = 1; i <= 5; ++i) studio.put(i);
            studio.isFull = false;
        };
        EXPECT_EQ(studio.moved()->version, 6u);
        ASSERT_EQ(studio.drawn.size(), 2u);
        EXPECT_EQ(studio.drawn.back().exposure, 5.0);
        studio.put(10);
        studio.isFull = true;
        EXPECT_THROW(studio.moved(), RequestError) << "of the newest pose";
    }
}

TEST(LiveDrawing, AnEqualRequestIsNotDrawnAgain) {
    Studio studio(0.0);
    studio.moved();
    studio.put(0);
    const Picture again = studio.moved();
    EXPECT_EQ(again->version, 2u);
    EXPECT_EQ(studio.drawn.size(), 1u);
}

TEST(LiveDrawing, StreamsOfEqualSettingsShareTheirPictures) {
    Studio studio(100.0);
    ASSERT_EQ(LiveDrawing::of(studio.view, {.targetMs = 100.0}), studio.drawing);
    EXPECT_NE(LiveDrawing::of(studio.view, {.targetMs = 50.0}), studio.drawing);
    EXPECT_NE(LiveDrawing::of(studio.view, {}), studio.drawing);
    std::promise<void> begun, other;
    studio.during = [&] {
        begun.set_value();
        other.get_future().wait();
    };
    const auto draw = studio.draw();
    auto first = std::async(std::launch::async,
                            [&] { return studio.drawing->moved(nullptr, std::nullopt, draw); });
    begun.get_future().wait();
    auto second = std::async(std::launch::async, [&] {
        other.set_value();
        return studio.drawing->moved(nullptr, std::nullopt, draw);
    });
    const Picture picture = first.get();
    EXPECT_EQ(second.get(), picture);
    EXPECT_EQ(studio.drawn.size(), 1u);
    const Picture finer = studio.drawing->refined(picture, draw);
    EXPECT_EQ(studio.drawing->refined(picture, draw), finer);
    EXPECT_EQ(studio.drawn.size(), 2u);
}

TEST(LiveDrawing, WhatWasMeasuredIsKeptWhileTheSizeStays) {
    Studio studio(100.0);
    for (int i = 1; i < 8; ++i) {
        studio.put(i);
        studio.moved();
    }
    const std::size_t level = studio.last->level;
    FrameRequest other = pose(20);
    other.effects.refraction = false;
    studio.view.put(other, "");
    EXPECT_EQ(studio.moved()->level, level);
    other.width = 1920;
    studio.view.put(other, "");
    EXPECT_EQ(studio.moved()->settings, (Level{0.125, true}));
}

}  // namespace
}  // namespace clerestory::test
