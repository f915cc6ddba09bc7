#include "interactive_client.h"

#include <atomic>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

namespace clerestory::bench {

double Record::await(std::uint64_t pose, bool whole) {
    std::unique_lock lock(mutex_);
    std::optional<double> at;
    const auto there = [&] {
        for (const Picture& p : pictures_) {
            if (p.pose < pose || (whole && !p.whole)) continue;
            at = p.at;
            return true;
        }
        return false;
    };
    if (!changed_.wait_for(lock, std::chrono::seconds(120), there)) {
        throw std::runtime_error("a picture did not arrive within two minutes");
    }
    return *at - sent_.at(pose);
}

namespace {

std::string headerIn(const std::string& head, const std::string& name) {
    const std::size_t at = head.find(name + ": ");
    if (at == std::string::npos) return {};
    const std::size_t begin = at + name.size() + 2;
    return head.substr(begin, head.find("\r\n", begin) - begin);
}

double durationIn(const std::string& timing, const std::string& name) {
    const std::size_t at = timing.find(name + ";dur=");
    return at == std::string::npos ? 0.0 : std::stod(timing.substr(at + name.size() + 5));
}

class StreamWay final : public Way {
public:
    StreamWay(httplib::Client poses, httplib::Client stream, const std::string& query,
              const std::string& first)
        : poses_(std::move(poses)), stream_(std::move(stream)) {
        send(0, first);
        reader_ = std::thread([this, query] {
            stream_.Get("/v1/stream?view=bench&" + query, [this](const char* data, std::size_t n) {
                text_.append(data, n);
                readParts();
                return !ending_;
            });
        });
        record.await(0, true);
    }
    ~StreamWay() override {
        ending_ = true;
        stream_.stop();
        reader_.join();
    }

    void send(std::uint64_t pose, const std::string& body) override {
        const double at = record.now();
        const auto reply = poses_.Put("/v1/views/bench", body, "application/json");
        if (!reply || reply->status != 204) throw std::runtime_error("a pose was refused");
        const std::uint64_t version =
            std::stoull(reply->get_header_value("Clerestory-View-Version"));
        record.sent(pose, at);
        const std::lock_guard lock(mutex_);
        poseOf_[version] = pose;
    }

private:
    void readParts() {
        const std::string type = "Content-Type: image/jpeg";
        for (;;) {
            const std::size_t at = text_.find(type), end = text_.find("\r\n\r\n", at);
            if (at == std::string::npos || end == std::string::npos) return;
            const std::string head = text_.substr(at, end + 2 - at);
            const std::size_t length = std::stoull(headerIn(head, "Content-Length"));
            if (text_.size() < end + 4 + length) return;
            text_.erase(0, end + 4 + length);
            const double now = record.now();
            const std::string level = headerIn(head, "Clerestory-Level");
            record.arrived({.at = now,
                            .pose = poseOf(std::stoull(headerIn(head, "Clerestory-View-Version"))),
                            .whole = level.empty() || level == "0",
                            .frameMs = durationIn(headerIn(head, "Server-Timing"), "frame")});
        }
    }
    // The answer to a pose can arrive after its picture.
    std::uint64_t poseOf(std::uint64_t version) {
        for (;;) {
            {
                const std::lock_guard lock(mutex_);
                const auto found = poseOf_.find(version);
                if (found != poseOf_.end()) return found->second;
            }
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        }
    }

    httplib::Client poses_, stream_;
    std::mutex mutex_;
    std::map<std::uint64_t, std::uint64_t> poseOf_;  // by version of the view
    std::string text_;
    std::atomic<bool> ending_{false};
    std::thread reader_;
};

class RequestWay final : public Way {
public:
    RequestWay(httplib::Client client, const std::string& first) : client_(std::move(client)) {
        thread_ = std::thread([this] { serve(); });
        send(0, first);
        record.await(0, true);
    }
    ~RequestWay() override {
        {
            const std::lock_guard lock(mutex_);
            ending_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }

    void send(std::uint64_t pose, const std::string& body) override {
        record.sent(pose, record.now());
        {
            const std::lock_guard lock(mutex_);
            next_ = {pose, body};
        }
        wake_.notify_all();
    }

private:
    void serve() {
        for (;;) {
            std::pair<std::uint64_t, std::string> own;
            {
                std::unique_lock lock(mutex_);
                wake_.wait(lock, [&] { return next_ || ending_; });
                if (ending_) return;
                own = *std::exchange(next_, std::nullopt);
            }
            const auto reply = client_.Post("/v1/frames", own.second, "application/json");
            if (!reply || reply->status != 200) continue;
            const std::string timing = reply->get_header_value("Server-Timing");
            record.arrived({.at = record.now(),
                            .pose = own.first,
                            .frameMs = durationIn(timing, "total") - durationIn(timing, "queue")});
        }
    }

    httplib::Client client_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::optional<std::pair<std::uint64_t, std::string>> next_;
    bool ending_ = false;
    std::thread thread_;
};

}  // namespace

std::unique_ptr<Way> streamWay(httplib::Client poses, httplib::Client stream,
                               const std::string& query, const std::string& first) {
    return std::make_unique<StreamWay>(std::move(poses), std::move(stream), query, first);
}

std::unique_ptr<Way> requestWay(httplib::Client client, const std::string& first) {
    return std::make_unique<RequestWay>(std::move(client), first);
}

}  // namespace clerestory::bench
