// setting_text.h: a setting's value as a person writes it.

#ifndef PERCALE_SETTING_TEXT_H
#define PERCALE_SETTING_TEXT_H

#include "percale/scene.h"

enum { PERCALE_SETTING_TEXT = 128 }; ///< bytes; three numbers of 24 characters, or the longest choice

/// "on", "20", "0.002", "0,-9.81,0", "auto"
void percale_setting_text(const PercaleSetting *setting, char text[PERCALE_SETTING_TEXT]);

#endif
