// The test program is its own import child process, so that these tests need no server.
#include "scene/import/in_process.h"

#include <gtest/gtest.h>

#include <string>

int main(int argc, char** argv) {
    if (argc > 1 && std::string(argv[1]) == "import-child") {
        return clerestory::importChildMain(argc, argv);
    }
    testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
