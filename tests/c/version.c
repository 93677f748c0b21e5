/* The library that is loaded is the one of the headers. */
#include "check.h"

int main(void) {
    CHECK(rlv_version() == RLV_VERSION);
    CHECK(RLV_MAKE_VERSION(1, 0, 0) > RLV_MAKE_VERSION(0, 1023, 4095));
    CHECK(RLV_MAKE_VERSION(0, 2, 0) > RLV_MAKE_VERSION(0, 1, 4095));
    return 0;
}
