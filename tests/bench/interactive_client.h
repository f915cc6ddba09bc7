// Two ways to send poses to a server and to receive pictures of them, with the time of each.
//
//     auto way = streamWay(server.client(), server.client(), "targetMs=100", firstBody);
//     way->send(1, body);
//     const double milliseconds = way->record.await(1, false);
#pragma once

#include "statistics.h"

#include <httplib.h>

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace clerestory::bench {

// What arrived of one mode of use, by milliseconds of one clock.
class Record {
public:
    struct Picture {
        double at = 0.0;
        std::uint64_t pose = 0;
        bool whole = true;
        double frameMs = 0.0;
    };

    double now() const { return watch_.milliseconds(); }
    void sent(std::uint64_t pose, double at) {
        const std::lock_guard lock(mutex_);
        sent_[pose] = at;
    }
    void arrived(const Picture& picture) {
        {
            const std::lock_guard lock(mutex_);
            pictures_.push_back(picture);
        }
        changed_.notify_all();
    }
    std::map<std::uint64_t, double> poses() const {
        const std::lock_guard lock(mutex_);
        return sent_;
    }
    std::vector<Picture> pictures() const {
        const std::lock_guard lock(mutex_);
        return pictures_;
    }
    // Milliseconds from sending the pose to its first picture, or its first whole one.
    double await(std::uint64_t pose, bool whole);

private:
    const Stopwatch watch_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::map<std::uint64_t, double> sent_;
    std::vector<Picture> pictures_;
};

// How poses reach the server and pictures come back.
class Way {
public:
    virtual ~Way() = default;
    virtual void send(std::uint64_t pose, const std::string& body) = 0;
    Record record;
};

// PUT of a live view, and a stream of it; `query`: further parameters of the stream. Returns when
// the picture of the first pose, number 0, is whole.
std::unique_ptr<Way> streamWay(httplib::Client poses, httplib::Client stream,
                               const std::string& query, const std::string& first);

// POST of the newest pose, one request at a time.
std::unique_ptr<Way> requestWay(httplib::Client client, const std::string& first);

}  // namespace clerestory::bench
