#include "cli/setting_text.h"

#include <string.h>

static void choice_text(const PercaleSetting *setting, char *text, size_t size)
{
    const char *choice = setting->choices;
    for (int left = (int)setting->value[0]; left > 0; --left) {
        const char *bar = strchr(choice, '|');
        choice = bar ? bar + 1 : "";
    }
    (void)snprintf(text, size, "%.*s", (int)strcspn(choice, "|"), choice);
}

void percale_setting_text(const PercaleSetting *setting, char text[PERCALE_SETTING_TEXT])
{
    const double *value = setting->value;
    const size_t size = PERCALE_SETTING_TEXT;
    switch (setting->kind) {
    case PERCALE_SETTING_SWITCH:
        (void)snprintf(text, size, "%s", value[0] != 0.0 ? "on" : "off");
        break;
    case PERCALE_SETTING_INTEGER:
        (void)snprintf(text, size, "%.0f", value[0]);
        break;
    case PERCALE_SETTING_NUMBER:
        (void)snprintf(text, size, "%.9g", value[0]);
        break;
    case PERCALE_SETTING_VECTOR:
        (void)snprintf(text, size, "%.12g,%.12g,%.12g", value[0], value[1], value[2]);
        break;
    case PERCALE_SETTING_CHOICE:
        choice_text(setting, text, size);
        break;
    }
}
