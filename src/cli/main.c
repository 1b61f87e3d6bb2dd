// The command line's table of contents: which command, and what every command has in common.

#include "cli/commands.h"
#include "cli/complaint.h"
#include "percale/percale.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const char HELP[] =
    "percale: fast, collision-true cloth on CPU cores\n"
    "\n"
    "  percale scenes [NAME]    list the built-in scenes; or one scene's settings with default, unit and "
    "range\n"
    "  percale run SCENE        simulate a built-in scene or a JSON scene file\n"
    "      --size N             approximate cloth vertex count of a built-in scene\n"
    "      --frames N           number of steps\n"
    "      --threads N          1..256; default: the machine's\n"
    "      --preset P           swift, balanced or accurate\n"
    "      --set key=value      any setting of the scene, as often as you like\n"
    "      --audit K            judge every K-th frame and the last (default 10)\n"
    "      --out DIR            write every cloth's motion there\n"
    "      --format pc2|obj     a point cache and its mesh (default), or one OBJ per frame\n"
    "      --json FILE|-        the report as JSON\n"
    "      --picture FILE.png   the last frame\n"
    "      --heat stretch|penetration    colours the picture's cloth: 0..10 % or 0..2 mm\n"
    "      --quiet              no table, no progress bar\n"
    "      --error-below MM, --resume FILE, --capsule FILE    not in this version\n"
    "  percale audit --cloth A.obj ... [--rest A0.obj ...] [--obstacle B.obj ...] [--thickness m] [--json "
    "FILE|-]\n"
    "                           judge meshes from files\n"
    "  percale untangle IN.obj ... [--seams FILE] [--obstacle B.obj ...] --out DIR [--json FILE|-]\n"
    "                           take apart what goes through itself, through each other and through "
    "obstacles\n"
    "      --seams FILE         JSON: pairs [vertex, vertex], or [cloth, vertex, cloth, vertex], from 0\n"
    "      --set thickness=m    distance kept (0.002)\n"
    "      --set layers=on      the cloths lie on one another, the first innermost (off)\n"
    "      --set rounds=n, sweeps=n, patience=n    work at most\n"
    "      --threads N, --quiet as above\n"
    "  percale --version, percale --help\n"
    "\n"
    "Exit codes: 0 done, 1 the simulation failed or something still crosses, 2 bad arguments or bad input "
    "(then nothing is written).\n";

static const struct Command {
    const char *name;
    int (*run)(int argument_count, char **arguments);
} COMMANDS[] = {
    {"scenes", percale_command_scenes},
    {"run", percale_command_run},
    {"audit", percale_command_audit},
    {"untangle", percale_command_untangle},
};

static bool asks_for_help(const char *argument)
{
    return strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0;
}

static int dispatch(int argument_count, char **arguments)
{
    if (argument_count < 2)
        return percale_complain(PERCALE_EXIT_USAGE, "no command: scenes, run, audit, untangle or --help");
    const char *name = arguments[1];
    if (asks_for_help(name) || (argument_count == 3 && asks_for_help(arguments[2]))) {
        (void)fputs(HELP, stdout);
        return PERCALE_EXIT_DONE;
    }
    if (strcmp(name, "--version") == 0) {
        (void)printf("percale %s\n", percale_version());
        return PERCALE_EXIT_DONE;
    }
    for (size_t index = 0; index < sizeof COMMANDS / sizeof COMMANDS[0]; ++index)
        if (strcmp(name, COMMANDS[index].name) == 0)
            return COMMANDS[index].run(argument_count - 2, arguments + 2);
    return percale_complain(PERCALE_EXIT_USAGE,
                            "unknown command '%s': scenes, run, audit, untangle or --help", name);
}

int main(int argument_count, char **arguments)
{
    int code = dispatch(argument_count, arguments);
    bool written = fflush(stdout) == 0 && !ferror(stdout);
    if (!written && code == PERCALE_EXIT_DONE)
        return percale_complain(PERCALE_EXIT_FAILED, "standard output can't be written");
    return code;
}
