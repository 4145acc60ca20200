// The contents of a report, and the data left out.
import * as state from '../state';

export function ReportBar() {
  const report = state.report.value;
  if (report === undefined) return null;
  const other = 'Read with other settings than the report: everything shown comes from the cycles in it.';
  const notes = state.isWhole.value ? report.notes : [other, ...report.notes];
  return (
    <details class="report-bar">
      <summary>{notes[0]}</summary>
      {notes.slice(1).map((note) => <p key={note}>{note}</p>)}
    </details>
  );
}
