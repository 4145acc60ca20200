/** The waveform of MA and SLO, the decoded tracks below it, the overview strip and the cursors. */
export function Wave() {
  return <section class="wave" aria-label="Waveform" />;
}
