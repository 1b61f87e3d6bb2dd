// commands.h: the commands of the command line; each takes the arguments after its name and returns the exit
// code.

#ifndef PERCALE_COMMANDS_H
#define PERCALE_COMMANDS_H

int percale_command_scenes(int argument_count, char **arguments);
int percale_command_run(int argument_count, char **arguments);
int percale_command_audit(int argument_count, char **arguments);
int percale_command_untangle(int argument_count, char **arguments);

#endif
