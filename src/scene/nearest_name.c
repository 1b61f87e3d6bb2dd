// The word that the user most likely meant: fewest letters to change (Levenshtein), first of equals.

#include "scene/settings.h"

#include <string.h>

enum { WORD_LIMIT = 32 }; // letters compared; every known name is shorter

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int letters_to_change(const char *a, int a_length, const char *b, int b_length)
{
    int row[WORD_LIMIT + 1];
    for (int j = 0; j <= b_length; ++j) {
        row[j] = j;
    }
    for (int i = 1; i <= a_length; ++i) {
        int diagonal = row[0];
        row[0] = i;
        for (int j = 1; j <= b_length; ++j) {
            const int replaced = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = smaller(replaced, 1 + smaller(row[j], row[j - 1]));
        }
    }
    return row[b_length];
}

const char *percale_nearest_name(const char *names, const char *word, int *length)
{
    const int word_length = (int)strnlen(word, WORD_LIMIT);
    const char *nearest = names;
    int fewest = 2 * WORD_LIMIT;
    *length = 0;
    for (const char *name = names; *name != '\0';) {
        const int name_length = (int)strcspn(name, "|");
        const int changes = letters_to_change(word, word_length, name, smaller(name_length, WORD_LIMIT));
        if (changes < fewest) {
            fewest = changes;
            nearest = name;
            *length = name_length;
        }
        name += name_length;
        name += *name == '|';
    }
    return nearest;
}
