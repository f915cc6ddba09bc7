#include "tests/fuzz/targets.h"

#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

namespace clerestory::test {

void fuzzJson(Bytes input) {
    const std::string_view bytes(reinterpret_cast<const char*>(input.data()), input.size());
    try {
        const FrameRequest request = frameRequestFrom(strictJson(bytes));
        require(request.width >= 1 && request.width <= kMaxEdge, "the width is in range");
        require(request.height >= 1 && request.height <= kMaxEdge, "the height is in range");
        require(problems(request).empty(), "what was let through is sound");
        const std::string text = canonicalText(request);
        require(text == canonicalText(frameRequestFrom(strictJson(bytes))),
                "and read the same twice");
    } catch (const RequestError& error) {
        const int status = error.problem().status;
        require(status == 400 || status == 422, "a refusal is 400 or 422");
        if (status == 400) return;  // repeats nothing of what was sent
        const std::string document = problemJson(error.problem(), "fuzz");
        require(nlohmann::json::accept(document), "a refusal is JSON whatever was sent");
        require(document.size() < 64 * bytes.size() + 65536, "a refusal does not swell");
    }
}

std::vector<std::string> jsonSeeds() {
    return {
        "{}",
        R"({"scene": "chapel", "camera": {"position": [0, 1.6, 6], "target": [0, 1.4, 0]}, "width": 64})",
        R"({"camera": {"cameraToWorld": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1], "convention": "opencv",
            "intrinsics": {"fx": 1e2, "fy": 100, "cx": 50.5, "cy": -0}}})",
        R"({"effects": {"emission": false}, "accuracy": {"preset": "fine", "samples": 4}, "time": 1.5})",
        R"({"accuracy": {"maxMilliseconds": 60}, "output": {"format": "npy", "channel": "depth"}})",
        R"({"overrides": [{"material": "floor", "roughness": 0.1, "baseColor": [1, 0.5, 0]}]})",
        R"({"environment": {"map": "sky", "rotation": [0, 0, 0, 1], "intensity": 1e-3}})",
        R"({"width": 1e999, "\u00e9\ud83d\ude00": [[[[[[[null, true]]]]]]], "width": -1})",
    };
}

}  // namespace clerestory::test
