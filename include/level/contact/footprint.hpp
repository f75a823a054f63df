// Where a contact with pressures on columns is: its projected area, half width, reach and largest pressure.
#pragma once

#include "level/contact/columns.hpp"

#include <vector>

namespace mlgimp
{

/// Fills in area, half_width, reach, crosses and peak_pressure; lambda: the pressures of the solve, [columns] Pa.
void MeasureFootprint(const ContactView &view, const ContactColumns &columns, const std::vector<double> &lambda,
                      ContactReport *report);

} // namespace mlgimp
