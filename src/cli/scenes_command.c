#include "cli/commands.h"
#include "cli/complaint.h"
#include "cli/options.h"
#include "cli/setting_text.h"
#include "percale/scene.h"

#include <stdio.h>

static const PercaleOptionKind KINDS[] = {{NULL, PERCALE_OPTION_SWITCH}};

static void list_scenes(void)
{
    for (uint32_t index = 0; percale_scene_name(index); ++index)
        (void)printf("%-12s %s\n", percale_scene_name(index), percale_scene_summary(index));
}

static void range_text(const PercaleSetting *setting, char *text, size_t size)
{
    switch (setting->kind) {
    case PERCALE_SETTING_SWITCH:
        (void)snprintf(text, size, "on|off");
        break;
    case PERCALE_SETTING_CHOICE:
        (void)snprintf(text, size, "%s", setting->choices);
        break;
    case PERCALE_SETTING_INTEGER:
    case PERCALE_SETTING_NUMBER:
    case PERCALE_SETTING_VECTOR:
        (void)snprintf(text, size, "%.12g..%.12g", setting->minimum, setting->maximum);
        break;
    }
}

static void list_settings(const PercaleScene *scene)
{
    uint32_t count = 0;
    const PercaleSetting *settings = percale_scene_settings(scene, &count);
    (void)printf("%-22s %-16s %-8s %-24s %s\n", "setting", "default", "unit", "range", "what");
    for (uint32_t index = 0; index < count; ++index) {
        char value[PERCALE_SETTING_TEXT];
        char range[PERCALE_SETTING_TEXT];
        percale_setting_text(&settings[index], value);
        range_text(&settings[index], range, sizeof range);
        (void)printf("%-22s %-16s %-8s %-24s %s\n", settings[index].name, value, settings[index].unit, range,
                     settings[index].help);
    }
    (void)printf("\n%u frames, %g frames/s, preset %s\n", (unsigned)percale_scene_default_frames(scene),
                 percale_scene_frame_rate(scene), percale_scene_preset(scene));
}

int percale_command_scenes(int argument_count, char **arguments)
{
    PercaleSceneError error = {""};
    PercaleOptions options;
    if (!percale_options_parse(argument_count, arguments, KINDS, &options, &error))
        return percale_complain(PERCALE_EXIT_USAGE, "scenes: %s", error.text);
    const char *name = percale_options_value(&options, NULL);
    size_t count = options.count;
    percale_options_free(&options);
    if (count > 1)
        return percale_complain(PERCALE_EXIT_USAGE, "scenes: '%s' is one scene too many", name);
    if (!name) {
        list_scenes();
        return PERCALE_EXIT_DONE;
    }
    PercaleScene *scene = percale_scene_open(name, 0, &error);
    if (!scene)
        return percale_complain(PERCALE_EXIT_USAGE, "%s", error.text);
    list_settings(scene);
    percale_scene_close(scene);
    return PERCALE_EXIT_DONE;
}
