/** The plots for the columns of a capture. */
import type { Column } from 'biss';
import type { PlotSpec } from './plot_view';

/** Plots of position and similar columns, whose names they have; degrees and millimetres instead of counts. */
export function columnPlots(columns: readonly Column[]): PlotSpec[] {
  return columns.filter(({ plot }) => plot > 0).sort((a, b) => a.plot - b.plot)
    .map(({ name, kind, title, valueUnit }) => {
      const quantity = kind === 'time' ? 'time' : valueUnit === 'Hz' ? 'rate' : 'number';
      const unit = quantity === 'number' ? valueUnit : '';
      return { id: name, title, quantity, unit, dots: false };
    });
}
