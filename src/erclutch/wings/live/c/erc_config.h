#pragma once

#include "erc_layout.h"

/* 0, or what is wrong with a configuration and its remedy, until the next call. */
const char *erc_config_error(const erc_config *config, uint64_t table_rows);
