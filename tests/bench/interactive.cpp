// `bench_interactive CLERESTORY [SCENE]`: a client that sends a pose every 50 ms, to a live view
// with a stream and as single requests of which one is in progress. Which poses do the pictures
// show, how old are they, when is the whole frame there, and how long does the next drag wait?
#include "command_line.h"
#include "interactive_client.h"
#include "program.h"
#include "statistics.h"
#include "tests/bench/child_process.h"
#include "tests/support/free_port.h"

#include <httplib.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace clerestory::bench {
namespace {

struct Options {
    std::string program, scene = "chapel";
    std::uint32_t width = 1280, height = 720;
    std::string accuracy = "standard";
    double seconds = 10.0, targetMs = 100.0, poseMs = 50.0;
    int rounds = 3, drags = 12;
};

class Served {
public:
    explicit Served(const Options& options) : port_(test::freePort()) {
        id_ = startProgram({options.program, "serve", "--port", std::to_string(port_), "--scene",
                            options.scene, "--frame-cache", "0", "--no-standby", "--deadline",
                            "600", "--log-level", "error"});
    }
    ~Served() { stopTree(id_); }
    Served(const Served&) = delete;
    Served& operator=(const Served&) = delete;

    httplib::Client client() const {
        httplib::Client client("127.0.0.1", port_);
        client.set_keep_alive(true);
        client.set_tcp_nodelay(true);
        client.set_read_timeout(600);
        return client;
    }

    void awaitReady() const {
        auto own = client();
        for (int i = 0; i < 3000; ++i) {
            const auto ready = own.Get("/readyz");
            if (ready && ready->status == 200) return;
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        throw std::runtime_error("the server is not ready after five minutes");
    }

private:
    const int port_;
    pid_t id_ = -1;
};

struct Camera {
    double eye[3], target[3];
};

// Poses on a circle about the default view of the scene.
std::string bodyOf(const Options& options, const Camera& camera, std::uint64_t pose) {
    const double angle = 0.05 * static_cast<double>(pose);
    const double radius =
        0.1 * std::hypot(camera.eye[0] - camera.target[0], camera.eye[1] - camera.target[1],
                         camera.eye[2] - camera.target[2]);
    char text[512];
    std::snprintf(text, sizeof text,
                  R"({"width": %u, "height": %u, "accuracy": "%s", "camera": {"position": )"
                  R"([%.9g, %.9g, %.9g], "target": [%.9g, %.9g, %.9g]}})",
                  options.width, options.height, options.accuracy.c_str(),
                  camera.eye[0] + radius * std::cos(angle), camera.eye[1],
                  camera.eye[2] + radius * std::sin(angle), camera.target[0], camera.target[1],
                  camera.target[2]);
    return text;
}

struct Figures {
    std::vector<double> rate, frameMs, latency, behind, wholeAfter, drag;
};

void sleepUntil(const Way& way, double at) {
    const double left = at - way.record.now();
    if (left > 0.0) std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(left));
}

void measureMotion(Way& way, const Options& options, const Camera& camera, std::uint64_t& pose,
                   Figures& figures) {
    const double start = way.record.now();
    const std::uint64_t first = pose + 1;
    const int count = static_cast<int>(1e3 * options.seconds / options.poseMs);
    for (int i = 0; i < count; ++i) {
        sleepUntil(way, start + i * options.poseMs);
        ++pose;
        way.send(pose, bodyOf(options, camera, pose));
    }
    const double end = way.record.now();
    figures.wholeAfter.push_back(way.record.await(pose, true));
    const auto poses = way.record.poses();
    std::uint64_t shown = first - 1;
    int frames = 0;
    for (const Record::Picture& picture : way.record.pictures()) {
        if (picture.at < start || picture.at > end || picture.pose <= shown) continue;
        shown = picture.pose;
        ++frames;
        figures.latency.push_back(picture.at - poses.at(shown));
        std::uint64_t newest = shown;
        while (poses.contains(newest + 1) && poses.at(newest + 1) <= picture.at) ++newest;
        figures.behind.push_back(static_cast<double>(newest - shown));
        if (picture.frameMs > 0.0) figures.frameMs.push_back(picture.frameMs);
    }
    figures.rate.push_back(1e3 * frames / (end - start));
}

// A pose at any moment while the view is at rest.
void measureDrags(Way& way, const Options& options, const Camera& camera, std::uint64_t& pose,
                  double wholeMs, Figures& figures) {
    for (int i = 0; i < options.drags; ++i) {
        ++pose;
        way.send(pose, bodyOf(options, camera, pose));
        const double moment = 160.0 + 2.0 * wholeMs * (i + 0.5) / options.drags;
        sleepUntil(way, way.record.poses().at(pose) + moment);
        ++pose;
        way.send(pose, bodyOf(options, camera, pose));
        figures.drag.push_back(way.record.await(pose, false));
        way.record.await(pose, true);
    }
}

Camera cameraOf(const Served& server) {
    auto client = server.client();
    const auto json = [&](const std::string& path) {
        const auto reply = client.Get(path);
        if (!reply || reply->status != 200) throw std::runtime_error("no answer to " + path);
        return nlohmann::json::parse(reply->body);
    };
    const nlohmann::json list = json("/v1/scenes");
    for (const auto& scene : list.at("scenes")) {
        if (!scene.value("default", false)) continue;
        const auto view = json("/v1/scenes/" + scene.at("id").get<std::string>()).at("defaultView");
        Camera camera{};
        for (std::size_t i = 0; i < 3; ++i) {
            camera.eye[i] = view.at("position").at(i);
            camera.target[i] = view.at("target").at(i);
        }
        return camera;
    }
    throw std::runtime_error("the server has no default scene");
}

double wholeFrameMs(const Served& server, const Options& options, const Camera& camera) {
    auto client = server.client();
    std::vector<double> times;
    for (std::uint64_t i = 0; i < 8; ++i) {
        const Stopwatch watch;
        const auto reply =
            client.Post("/v1/frames", bodyOf(options, camera, 100'000 + i), "application/json");
        if (!reply || reply->status != 200) throw std::runtime_error("a frame was not answered");
        if (i > 0) times.push_back(watch.milliseconds());
    }
    return median(times);
}

void print(const char* name, const Figures& f, double wholeMs) {
    const double frameMs = f.frameMs.empty() ? wholeMs : median(f.frameMs);
    const double rate = median(f.rate);
    std::printf("%-22s %8.1f %8.0f %7.2f | %6.0f %6.0f %7.1f %6.0f | %8.0f %6.1f | %6.0f %6.0f\n",
                name, rate, frameMs, 1e-3 * rate * frameMs, percentile(f.latency, 0.5),
                percentile(f.latency, 0.99), percentile(f.behind, 0.5), percentile(f.behind, 1.0),
                median(f.wholeAfter), median(f.wholeAfter) / wholeMs, percentile(f.drag, 0.5),
                percentile(f.drag, 1.0));
}

int measureInteractive(const Options& options) {
    Served server(options);
    server.awaitReady();
    const Camera camera = cameraOf(server);
    const std::string first = bodyOf(options, camera, 0);
    char paced[64];
    std::snprintf(paced, sizeof paced, "targetMs=%g", options.targetMs);
    struct Mode {
        const char* name;
        std::function<std::unique_ptr<Way>()> make;
        Figures figures;
    };
    Mode modes[] = {{"stream",
                     [&] { return streamWay(server.client(), server.client(), "fps=60", first); },
                     {}},
                    {"requests", [&] { return requestWay(server.client(), first); }, {}},
                    {"stream with targetMs",
                     [&] { return streamWay(server.client(), server.client(), paced, first); },
                     {}}};
    const double wholeMs = wholeFrameMs(server, options, camera);
    for (int round = 0; round < options.rounds; ++round) {
        for (Mode& mode : modes) {
            const std::unique_ptr<Way> way = mode.make();
            std::uint64_t pose = 0;
            measureMotion(*way, options, camera, pose, mode.figures);
            measureDrags(*way, options, camera, pose, wholeMs, mode.figures);
        }
    }
    std::printf(
        "%s, %ux%u, %s: a whole frame takes %.0f ms; a pose every %.0f ms; targetMs %.0f; "
        "%u processors, load %.1f\n",
        options.scene.c_str(), options.width, options.height, options.accuracy.c_str(), wholeMs,
        options.poseMs, options.targetMs, std::thread::hardware_concurrency(), loadAverage());
    std::printf("%-22s %8s %8s %7s | %6s %6s %7s %6s | %8s %6s | %6s %6s\n", "", "frames/s",
                "frame ms", "busy", "p50", "p99", "behind", "most", "whole", "ratio", "drag",
                "most");
    for (const Mode& mode : modes) print(mode.name, mode.figures, wholeMs);
    std::printf(
        "busy: share of the time that frames are drawn. p50, p99: milliseconds from a pose to its "
        "picture.\nbehind, most: poses sent after the shown one when a picture arrives, median and "
        "maximum.\nwhole, ratio: milliseconds from the last pose to its whole frame, and relative "
        "to the time of one.\ndrag, most: milliseconds from a pose to its picture, sent at any "
        "moment while the view is at rest.\n");
    return 0;
}

int measure(int argc, char** argv) {
    CommandLine line("A client that sends a pose every 50 ms");
    Options options;
    line.addRequired("program", options.program, "the program that is measured");
    line.add("scene", options.scene, "a built-in scene or a file");
    line.add("--width", options.width);
    line.add("--height", options.height);
    line.add("--accuracy", options.accuracy);
    line.add("--target", options.targetMs, "targetMs", {10, 5000});
    line.add("--pose", options.poseMs, "milliseconds between poses", {1, 1000});
    line.add("--rounds", options.rounds, "", {1, 100});
    line.add("--drags", options.drags, "of each round", {1, 1000});
    line.add("--seconds", options.seconds, "of motion in each round");
    if (const auto status = line.parse(argc, argv)) return *status;
    return measureInteractive(options);
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_interactive", clerestory::bench::measure, argc,
                                         argv);
}
