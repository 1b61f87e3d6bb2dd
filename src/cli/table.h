// table.h: the report as a person reads it, on standard output.

#ifndef PERCALE_TABLE_H
#define PERCALE_TABLE_H

#include "cli/report.h"

void percale_table_print(const PercaleReport *report);
void percale_audit_table_print(const PercaleAuditReport *report);
void percale_untangle_table_print(const PercaleUntangleCommandReport *report);

#endif
