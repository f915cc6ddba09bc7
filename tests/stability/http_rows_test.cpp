// Rows of the stability table over HTTP.
#include "tests/stability/table.h"
#include "tests/support/test_server.h"

#include <cstdio>

namespace clerestory::test {
namespace {

TEST(HttpRows, ARestartedServerSendsTheSameBytes) {
    std::string body, etag;
    for (int start = 0; start < 2; ++start) {
        TestServer server;
        auto client = server.client();
        const auto frame = postJson(client, "/v1/frames", smallFrame());
        ASSERT_TRUE(frame);
        ASSERT_EQ(frame->status, 200);
        if (start > 0) {
            EXPECT_TRUE(
                atMost("order", "server restarted: bytes differ", frame->body != body, 0.0));
            EXPECT_TRUE(atMost("order", "server restarted: ETags differ",
                               frame->get_header_value("ETag") != etag, 0.0));
        }
        body = frame->body;
        etag = frame->get_header_value("ETag");
    }
}

TEST(HttpRows, EveryFieldOfViewIsDrawnOrRefused) {
    auto client = sharedServer().client();
    const auto status = [&](double degrees) {
        char more[96];
        std::snprintf(more, sizeof more, R"("camera": {"yfov": %.17g})",
                      degrees * 0.017453292519943295);
        const auto answer = postJson(client, "/v1/frames?explain=health", smallFrame(more));
        if (!answer) return 0;
        if (answer->status == 200) {
            const auto health = nlohmann::json::parse(partsOf(*answer)[1].second)["health"];
            EXPECT_TRUE(atMost("non-finite scan", "bad texels of a frame's targets",
                               health["nonFinite"].get<double>() + health["negative"].get<double>(),
                               0.0))
                << degrees;
        }
        return answer->status;
    };
    for (const double degrees : {1.0, 2.0, 90.0, 178.0, 179.0}) {
        EXPECT_TRUE(
            atMost("field of view", "1..179 refused over HTTP", status(degrees) != 200, 0.0))
            << degrees;
    }
    for (const double degrees : {0.0, 0.99, 179.01, 180.0, -90.0}) {
        EXPECT_TRUE(atMost("field of view", "outside drawn over HTTP", status(degrees) != 422, 0.0))
            << degrees;
    }
}

}  // namespace
}  // namespace clerestory::test
