// Precompiled for the rooms that read and write JSON.
#include "pch_base.h"

#include <nlohmann/json.hpp>
