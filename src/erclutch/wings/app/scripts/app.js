// What a page of the app cannot do alone. Each script looks for its own part of the page, and does nothing where that is missing.

import { checkTheChoice } from "./comparison.js";
import { fillFrames } from "./framed_reports.js";
import { followTheForm, warnOfLogsApart } from "./reading_form.js";
import { followTheJob } from "./running_job.js";
import { showSignals } from "./signal_plots.js";
import { takeDroppedFiles } from "./upload.js";

takeDroppedFiles();
followTheForm();
warnOfLogsApart();
showSignals();
followTheJob();
checkTheChoice();
fillFrames();
