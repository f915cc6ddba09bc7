// Precompiled for the test programs that start a server.
#include "pch_test.h"

#include <httplib.h>
#include <nlohmann/json.hpp>
