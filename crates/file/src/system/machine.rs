use std::fs;

/// Returns the name of this machine, if known.
pub fn machine_name() -> Option<String> {
    #[cfg(unix)]
    let told = rustix::system::uname().nodename().to_str().ok().map(str::to_owned);
    #[cfg(not(unix))]
    let told: Option<String> = None;
    let named = || ["HOSTNAME", "COMPUTERNAME"].iter().find_map(|name| std::env::var(name).ok());
    told.or_else(named).map(|name| name.trim().to_owned()).filter(|name| !name.is_empty())
}

/// Returns the model name of the processor, if known.
pub fn processor_name() -> Option<String> {
    let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let mut fields = cpuinfo.lines().filter_map(|line| line.split_once(':'));
    let model = fields.find(|(key, _)| key.trim() == "model name").map(|(_, name)| name.trim().to_owned());
    model.or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
}
