// `clerestory sign`: signs a link that is valid for a limited time.
#include "server/cli/commands.h"
#include "server/http/access.h"

#include <iostream>

namespace clerestory {

int runSign(const CommandLine& line) {
    const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
    std::cout << signedLink(secretFrom(line.sign.keyFile), line.sign.link,
                            now + std::chrono::seconds(line.sign.validSeconds))
              << "\n";
    return 0;
}

}  // namespace clerestory
